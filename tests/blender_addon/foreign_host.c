/* SPDX-License-Identifier: Apache-2.0 */
/* A host with an Embree and an OpenEXR of its own: functions of the names that our libraries import, which
 * end the process when one of ours calls them. test_inprocess.py loads it as a host's libraries are, for all
 * to see. */
#include <stdio.h>
#include <stdlib.h>

static void captured(const char *name) {
    fprintf(stderr, "captured %s\n", name);
    abort();
}

/* clang-format off */
#define FOREIGN(name) void name(void); void name(void) { captured(#name); }
/* clang-format on */

FOREIGN(rtcAttachGeometryByID)
FOREIGN(rtcCommitGeometry)
FOREIGN(rtcCommitScene)
FOREIGN(rtcGetDeviceError)
FOREIGN(rtcGetGeometry)
FOREIGN(rtcGetGeometryBufferData)
FOREIGN(rtcIntersect1)
FOREIGN(rtcNewDevice)
FOREIGN(rtcNewGeometry)
FOREIGN(rtcNewScene)
FOREIGN(rtcOccluded1)
FOREIGN(rtcPointQuery)
FOREIGN(rtcReleaseDevice)
FOREIGN(rtcReleaseGeometry)
FOREIGN(rtcReleaseScene)
FOREIGN(rtcSetGeometryUserData)
FOREIGN(rtcSetNewGeometryBuffer)
FOREIGN(rtcSetSceneFlags)
FOREIGN(rtcSetSharedGeometryBuffer)
FOREIGN(exr_add_channel)
FOREIGN(exr_add_part)
FOREIGN(exr_encoding_choose_default_routines)
FOREIGN(exr_encoding_destroy)
FOREIGN(exr_encoding_initialize)
FOREIGN(exr_encoding_run)
FOREIGN(exr_encoding_update)
FOREIGN(exr_finish)
FOREIGN(exr_initialize_required_attr)
FOREIGN(exr_start_read)
FOREIGN(exr_start_write)
FOREIGN(exr_write_header)
FOREIGN(exr_write_scanline_chunk)
FOREIGN(exr_write_scanline_chunk_info)
