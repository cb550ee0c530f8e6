/* SPDX-License-Identifier: Apache-2.0 */
/* What a render to an error has still to do, by what its passes tell.
 *
 * The squared error is a sum of parts: noise and bias, of wavefronts, of photons and of paths. Each falls
 * with a power of its own, with the passes and, faster or slower, with their size. */
#include "core/checked.h"
#include "render/render_pass_state.h"

/* The powers with which the squares of noise and bias fall; measured on the bundled scenes, ball and stack
 * and brilliant. Photons' kernels shrink with the passes, and what they learn from larger ones is narrower
 * still; places of wavefronts are spread evenly over all passes. Paths know but noise. */
typedef struct Powers {
    double noise, bias, noise_size, bias_size;
} Powers;
static const Powers powers[ERROR_PARTS] = {[ERROR_WAVES] = {1.5, 0, 0.84, 0.8},
    [ERROR_PHOTONS] = {0.8, 0.66, 0.72, 1.2},
    [ERROR_PATHS] = {1, 0, 1, 0}};
/* In the mean a round to come takes photons so many times as long: what it lacks at its first look passes of
 * one size make up for slowly. Geometric mean over 24 casters of bench/plan, to a third and an eighth of the
 * first error. */
#define SLIP_PHOTONS 1.6
/* Passes that are so many times as large take that power of it as long: part of their time is eye paths. */
#define PASS_TIME_POWER 0.7
/* How much faster or slower than these powers a round's errors may seem to fall; and the squared spread of
 * their logarithms that is taken for certain of these powers as such, or for each part of it that is noise.
 */
#define SPEED_MIN 0.7
#define SPEED_MAX 1.6
#define SPEED_PRIOR 0.03
#define SPEED_NOISE 100.0
/* Another round must promise to be over in that part of what is left of this one. */
#define ROUND_GAIN 0.85
#define GROWTH_MIN 1.3
enum { GROWTH_STEPS = 24, HALVINGS = 24 };
#define PASSES_MOST 1e7

/* The squared error, over what is said of it now, after `times` the passes, each so much larger. */
static double falls(const ErrorParts *e, double times, double growth) {
    double now = 0, then = 0;
    for (int i = 0; i < ERROR_PARTS; i++) {
        const Powers *p = &powers[i];
        now += e->noise[i] + e->bias[i];
        then += e->noise[i] * pow(times, -p->noise) * pow(growth, -p->noise_size);
        then += e->bias[i] * pow(times, -p->bias) * pow(growth, -p->bias_size);
    }
    return now > 0 ? then / now : 0;
}

double forecast_passes(const ErrorParts *e, double passes, double error, double growth, double least) {
    double wanted = square(error / e->total);
    if (falls(e, least / passes, growth) <= wanted) return least;
    double low = least, high = PASSES_MOST;
    for (int i = 0; i < HALVINGS; i++) {
        double middle = sqrt(low * high);
        *(falls(e, middle / passes, growth) > wanted ? &low : &high) = middle;
    }
    return high;
}

/* By the parts of the error. */
static double slip(const ErrorParts *e) {
    double all = 0, photons = e->noise[ERROR_PHOTONS] + e->bias[ERROR_PHOTONS];
    for (int i = 0; i < ERROR_PARTS; i++) all += e->noise[i] + e->bias[i];
    return all > 0 ? pow(SLIP_PHOTONS, photons / all) : 1;
}

/* Bias of wavefronts does not fall with the passes. */
static bool is_reached(const ErrorParts *e, double passes, double error, double growth) {
    return falls(e, PASSES_MOST / passes, growth) <= square(error / e->total);
}

NextRound forecast_round(
    const ErrorParts *e, double passes, double error, double most, double least, Budget budget) {
    double then = error / budget.error; /* what passes as they are now would have to reach */
    double left = forecast_passes(e, passes, error, 1, least) - passes;
    NextRound best = {0, left, 1};
    if (most < GROWTH_MIN) return best;
    if (!is_reached(e, passes, error, 1)) {
        double growth_s = pow(most, PASS_TIME_POWER);
        best = (NextRound){most, PASSES_MOST * growth_s, growth_s};
    }
    for (int i = 1; i <= GROWTH_STEPS; i++) {
        double growth = pow(most, (double)i / GROWTH_STEPS), growth_s = pow(growth, PASS_TIME_POWER);
        if (growth < GROWTH_MIN || !is_reached(e, passes, then, growth)) continue;
        double cost = forecast_passes(e, passes, then, growth, least) * growth_s * budget.cost;
        if (cost < (best.growth > 0 ? best.cost : ROUND_GAIN * left))
            best = (NextRound){growth, cost, growth_s};
    }
    if (best.growth > 0) best.cost *= slip(e);
    return best;
}

/* How far an error lies above the present one, as a logarithm, and how far the parts let expect. */
typedef struct Above {
    double stated, expected;
} Above;

static Above above(const ErrorParts *e, double passes, const PastError *p) {
    return (Above){log(p->error / e->total), 0.5 * log(falls(e, p->passes / passes, 1) / falls(e, 1, 1))};
}

static bool is_known(const PastError *p, double passes) { return p->error > 0 && p->passes < passes; }

/* By a regression of the errors so far. */
static double speed_of(const ErrorParts *e, double passes, const PastErrors *past) {
    double n = 1, x = 0, y = 0, xx = 0, xy = 0, yy = 0; /* the present one is 0, 0 */
    for (int i = 0; i < PAST_ERRORS; i++) {
        if (!is_known(&past->items[i], passes)) continue;
        Above a = above(e, passes, &past->items[i]);
        n++;
        x += a.expected;
        y += a.stated;
        xx += square(a.expected);
        xy += a.expected * a.stated;
        yy += square(a.stated);
    }
    if (n < 3) return 1;
    xx -= x * x / n, xy -= x * y / n, yy -= y * y / n;
    double noise = fmax(yy - (xx > 0 ? xy * xy / xx : 0), 0) / (n - 2);
    double prior = fmax(SPEED_PRIOR, SPEED_NOISE * noise);
    return clamp((prior + xy) / (prior + xx), SPEED_MIN, SPEED_MAX);
}

Course forecast_course(const ErrorParts *e, double passes, const PastErrors *past) {
    double speed = speed_of(e, passes, past), sum = 0, count = 1;
    for (int i = 0; i < PAST_ERRORS; i++) {
        const PastError *p = &past->items[i];
        if (!is_known(p, passes) || 4 * p->passes < 3 * passes) continue;
        Above a = above(e, passes, p);
        sum += a.stated - speed * a.expected;
        count++;
    }
    return (Course){e->total * exp(sum / count), speed};
}
