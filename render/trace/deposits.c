/* SPDX-License-Identifier: Apache-2.0 */
#include "render/trace/deposits.h"

#include "core/checked.h"

void flux_account_add(FluxAccount *sum, const FluxAccount *part) {
    sum->emitted = rgb_add(sum->emitted, part->emitted);
    sum->landed = rgb_add(sum->landed, part->landed);
    sum->straight = rgb_add(sum->straight, part->straight);
    sum->absorbed = rgb_add(sum->absorbed, part->absorbed);
    sum->escaped = rgb_add(sum->escaped, part->escaped);
    sum->cut = rgb_add(sum->cut, part->cut);
    sum->bent = rgb_add(sum->bent, part->bent);
    sum->dropped = rgb_add(sum->dropped, part->dropped);
    sum->photons += part->photons;
    sum->rays += part->rays;
    sum->deposits += part->deposits;
    sum->non_finite += part->non_finite;
}

/* Octahedral map: Cigolle et al. 2014, "A survey of efficient representations for independent unit vectors".
 */
void normal_encode(V3 n, int16_t out[2]) {
    double s = 1 / (fabs(n.x) + fabs(n.y) + fabs(n.z)), x = n.x * s, y = n.y * s;
    if (n.z < 0) {
        double fx = (1 - fabs(y)) * copysign(1, x), fy = (1 - fabs(x)) * copysign(1, y);
        x = fx;
        y = fy;
    }
    out[0] = (int16_t)lrint(x * 32767);
    out[1] = (int16_t)lrint(y * 32767);
}

V3 normal_decode(const int16_t n[2]) {
    double x = n[0] / 32767.0, y = n[1] / 32767.0, z = 1 - fabs(x) - fabs(y), fold = fmax(-z, 0);
    return v3_normalize(v3(x - copysign(fold, x), y - copysign(fold, y), z));
}

static FluxAccount per_photon(FluxAccount a, double photons) {
    double s = 1 / photons;
    Rgb *parts[] = {&a.emitted, &a.landed, &a.straight, &a.absorbed, &a.escaped, &a.cut, &a.bent, &a.dropped};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) *parts[i] = rgb_scale(*parts[i], s);
    return a;
}

cau_result deposits_join(const PhotonRun *run, DepositList *out, FluxAccount *account, CauError *err) {
    FluxAccount sum[2] = {0};
    size_t lamp_batches = photon_batches(run->photons);
    out->count = 0;
    for (size_t i = 0; i < out->batch_count; i++) {
        PhotonBatch *b = &out->batches[i];
        if (b->out_of_memory ||
            !array_reserve((void **)&out->items, &out->capacity, out->count + b->count, sizeof *out->items))
            return error_set(err, CAU_ERROR_RESOURCE,
                "out of memory for %zu photon deposits; use fewer photons per pass", out->count + b->count);
        if (b->count) memcpy(out->items + out->count, b->items, b->count * sizeof *b->items);
        out->count += b->count;
        flux_account_add(&sum[i >= lamp_batches], &b->account);
    }
    if (run->photons) {
        sum[0] = per_photon(sum[0], run->photons);
        flux_account_add(account, &sum[0]);
    }
    if (!run->bent_photons) return CAU_OK;
    sum[1] = per_photon(sum[1], run->bent_photons);
    flux_account_add(run->bent_account, &sum[1]);
    return CAU_OK;
}

void deposits_free(DepositList *list) {
    for (size_t i = 0; i < list->batch_count; i++) free(list->batches[i].items);
    free(list->batches);
    free(list->items);
    *list = (DepositList){0};
}
