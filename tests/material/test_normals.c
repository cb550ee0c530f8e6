/* SPDX-License-Identifier: Apache-2.0 */
/* Interpolated normals: where they disagree with the geometry, light neither leaks through nor turns to NaN.
 */
#include "cases.h"

#include <math.h>

static void no_leak(const Case *c, Rng *rng) {
    if (!c->m.kind->eval) return;
    for (int i = 0; i < 2000; i++) {
        ShadingFrame f = make_frame(rng, i & 1, 0.2 + rng_next(rng));
        V3 wi = direction_at(&f, rng_next(rng), rng), wo = random_direction(rng);
        if (v3_dot(wi, f.ng) <= 0.0) continue;
        double pdf;
        Rgb value = c->m.kind->eval(&c->m, &f, wi, wo, LOBE_ALL, &pdf);
        V3 n = v3_dot(wi, f.ns) < 1e-4 ? f.ng : f.ns;
        if ((v3_dot(wo, n) > 0.0) != (v3_dot(wo, f.ng) > 0.0))
            expect_true(
                c, "nothing where the normals disagree about the side", pdf == 0.0 && rgb_black(value));
    }
}

static void light_does_not_leak(void **state) {
    (void)state;
    for_each_case(no_leak);
}

/* Seen from behind the interpolated normal, as near silhouettes: the geometric one takes its place. */
static void from_behind(const Case *c, Rng *rng) {
    for (int i = 0; i < 20; i++) {
        ShadingFrame f = make_frame(rng, true, 0.8);
        V3 s = v3_sub(f.ng, v3_scale(f.ns, v3_dot(f.ng, f.ns)));
        V3 wi = v3_normalize(v3_mad(s, -0.05, f.ns));
        assert_true(v3_dot(wi, f.ng) > 0.0 && v3_dot(wi, f.ns) < 0.0);
        ShadingFrame flat = {f.ng, f.ng, f.front};
        Shares seen = sample_shares(&c->m, &f, wi, LOBE_ALL, 4, 8),
               want = sample_shares(&c->m, &flat, wi, LOBE_ALL, 4, 8);
        expect_near(c, "as with the flat normal", seen.total.g, want.total.g, 1e-12);
    }
}

static void silhouettes_use_the_flat_normal(void **state) {
    (void)state;
    for_each_case(from_behind);
}

int run_normal_tests(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_does_not_leak),
        cmocka_unit_test(silhouettes_use_the_flat_normal),
    };
    return cmocka_run_group_tests_name("normals", tests, NULL, NULL);
}
