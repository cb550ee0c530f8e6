/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The files that a study writes; each into a stream, which files.c puts into place. */
#ifndef ACCURACY_WRITE_H
#define ACCURACY_WRITE_H

#include "accuracy/study.h"

/** One line per row; the columns are those of its first line. An unknown stated error is empty. */
cau_result write_csv(const Study *study, FILE *out);

/** A gnuplot script that reads no other file and writes error.svg and stated.svg. */
cau_result write_plot(const Study *study, FILE *out);

/** The HTML page, which shows the files beside it; `plotted`: the plots are there. */
cau_result write_page(const Study *study, bool plotted, FILE *out);

#endif
