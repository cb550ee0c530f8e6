/* SPDX-License-Identifier: Apache-2.0 */
/* How many photons an indirect layer has beside the direct one of its light.
 *
 * Of two layers whose errors add up and whose squares fall as 1 / n, the sum falls fastest with n in
 * proportion to sqrt(error^2 / cost of one) (Neyman 1934). A round tells both, so the next one has that;
 * between lights nothing is shared out, for a layer's strength may be changed later. Cost is counted in rays,
 * for the picture must not depend on the machine. */
#include "render/render_pass_state.h"

#include "core/checked.h"

/* Few passes know the errors ill, and kernels are learned from the photons of one. */
#define SHARE_MOST 8.0
/* The squared error falls with that power of a layer's photons: render_forecast.c has it by their kinds. */
#define SIZE_POWER 0.8

/* Sum of squares over the picture. */
static double error2(const cau_render *r, size_t g, int kind) {
    ErrorParts e = render_layer_parts(r, g, kind);
    double sum = 0;
    for (int i = 0; i < ERROR_PARTS; i++) sum += e.noise[i] + e.bias[i];
    return sum;
}

static double rays(const RenderGroup *g, int kind) {
    uint64_t count = g->accounts[kind].rays + g->bent[kind].rays + (kind ? 0 : g->wave_account.rays);
    return (double)count;
}

/* What of photons_per_pass a layer has. */
static double part_of_pass(double share, int kind) { return fmin(kind ? share : 1 / share, 1); }

Budget budget_look(cau_render *r) {
    double before = 0, after = 0, cost = 0, cost_after = 0;
    for (size_t i = 0; i < r->group_count; i++) {
        RenderGroup *g = &r->groups[i];
        double error[2] = {error2(r, i, 0), error2(r, i, 1)}, now = render_share(g, 0);
        double times = sqrt(error[1] / error[0] * rays(g, 0) / rays(g, 1));
        if (g->direct && g->indirect && isfinite(times) && times > 0)
            g->share[1] = clamp(now * times, 1 / SHARE_MOST, SHARE_MOST);
        for (int k = 0; k < 2; k++) {
            double more = part_of_pass(render_share(g, 1), k) / part_of_pass(now, k);
            before += error[k];
            after += error[k] * pow(more, -SIZE_POWER);
            cost += rays(g, k);
            cost_after += rays(g, k) * more;
        }
    }
    if (!(before > 0) || !(cost > 0)) return BUDGET_AS_IS;
    return (Budget){sqrt(after / before), cost_after / cost};
}

void budget_take(cau_render *r, bool learned) {
    for (size_t i = 0; i < r->group_count; i++) r->groups[i].share[0] = learned ? r->groups[i].share[1] : 0;
}
