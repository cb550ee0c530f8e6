/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  How wide estimator P's kernels are: where bias and noise balance, learned from the photons themselves.
 *
 *  A kernel of radius r has variance A / (n r^2) after n passes and bias B r^2. Both are measured - the
 *  variance by the spread of replicas, the squared bias by products of two replicas' own estimates, which no
 *  noise makes positive - and summed over a window around the pixel, wide enough for some independent
 * kernels. With radii that shrink as n^(-1/4) the mean square error of the mean over the passes is least
 * where r^6 = A / (12 n B^2): it has 2/3 of a pass's variance over n^(1/2), and twice the last kernel's bias.
 * Wide ones shrink less (photon_gather.c). Where no bias shows the radius grows by a bounded factor; where
 * there is structure it falls at once. It goes to zero with the photons everywhere, without a floor. (The
 * balance of the two: Kaplanyan and Dachsbacher 2013, who estimate the bias by derivatives.) */
#ifndef RENDER_FILM_BANDWIDTH_H
#define RENDER_FILM_BANDWIDTH_H

#include "render/film/film.h"
#include "render/gather/photon_gather.h"

/** State of one layer. Zero-initialise; owned. */
typedef struct Bandwidth {
    int width, height;
    float *radius; /**< [height * width] when RADIUS_PHOTONS photons are there, in pixel footprints */
    Film bias;     /**< of the passes: see KernelImages */
    Film waves;    /**< 1 channel, where estimator W draws: its bias, of the passes that check it */
    bool tried;    /**< the radii were learned */
} Bandwidth;

/** `waves`: estimator W draws a part of the layer. */
cau_result bandwidth_create(Bandwidth *out, int width, int height, double radius, bool waves, CauError *err);
/** Forgets what it has learned; the films are left alone. */
void bandwidth_restart(Bandwidth *b, double radius);
void bandwidth_free(Bandwidth *b);
double bandwidth_mean_radius(const Bandwidth *b);

/** How replicas were gathered that radii are learned from. */
typedef struct BandwidthTrial {
    double shrink; /**< by radii `radius` times this */
    double most;   /**< what kernels may cost, as KernelImages count it */
    bool settle;   /**< go half of the way only: radii near where they belong jump about it by chance */
} BandwidthTrial;

/** New radii from replicas: `film` of the light, `bias` of KernelImages.bias, `cost` the last one's.
 * `falling` becomes the share of the light whose kernels are far too wide still. */
cau_result bandwidth_learn(Bandwidth *b, const Film *film, const Film *bias, const double *cost,
    const BandwidthTrial *trial, double *falling, CauError *err);

/** Squared bias of the mean over the passes at a pixel, mean of the channels, from their estimates of it:
 * without bias its expectation is 0, so it may be negative. 0 with fewer than 2 passes. */
double bandwidth_bias2(const Film *bias, size_t pixel);

/** Size of the bias around a pixel, of kernels and wavefronts: root of the mean of the 5 x 5 squares around
 * it, 0 where that is negative. */
double bandwidth_bias(const Bandwidth *b, size_t pixel);

/** Mean of the squared bias over the picture, at least 0. */
double bandwidth_mean_bias2(const Bandwidth *b);

#endif
