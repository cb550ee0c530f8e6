/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The Python that runs inside Blender. The build makes these texts from the files of the same names. */
#ifndef COMPOSITE_HOSTS_SCRIPTS_H
#define COMPOSITE_HOSTS_SCRIPTS_H

extern const char host_blender_script[], host_blender_read[];

#endif
