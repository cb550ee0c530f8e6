/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "image/layer_names.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const lights[] = {"key", "Key.001", "Key_001", "a very long name of a light", "sun_ind",
    "E", "", "01 rim", "K\xc3\xbchl", "a very long name of a lamp!", "caustic_bias", "key"};
enum { LIGHTS = sizeof lights / sizeof *lights };

static void names_are_short_plain_and_different(void **state) {
    (void)state;
    LayerBase base[LIGHTS];
    assert_int_equal(layer_names_map(lights, LIGHTS, base, NULL), CAU_OK);
    for (int i = 0; i < LIGHTS; i++) {
        char channel[512], light[64];
        cau_layer_kind kind;
        snprintf(channel, sizeof channel, "%s_ind_bias.R", base[i].name);
        assert_true(strlen(channel) <= 31);
        assert_int_equal(
            strspn(base[i].name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_"),
            strlen(base[i].name));
        assert_true(layer_name_parse(base[i].name, light, &kind));
        assert_int_equal(kind, CAU_LAYER_RADIANCE); /* no name looks like one of our suffixes */
        for (int k = 0; k < i; k++) assert_string_not_equal(base[i].name, base[k].name);
    }
}

static void plain_names_stay(void **state) {
    (void)state;
    const char *two[] = {"key", "Key.001"};
    LayerBase base[2];
    assert_int_equal(layer_names_map(two, 2, base, NULL), CAU_OK);
    assert_string_equal(base[0].name, "caustics_key");
    assert_false(base[0].mapped);
    assert_string_equal(base[1].name, "caustics_Key_001");
    assert_true(base[1].mapped);
}

static void order_does_not_matter(void **state) {
    (void)state;
    const char *forward[] = {"Key.001", "Key_001", "a very long name 1", "a very long name 2"};
    const char *backward[] = {"a very long name 2", "a very long name 1", "Key_001", "Key.001"};
    LayerBase a[4], b[4];
    assert_int_equal(layer_names_map(forward, 4, a, NULL), CAU_OK);
    assert_int_equal(layer_names_map(backward, 4, b, NULL), CAU_OK);
    for (int i = 0; i < 4; i++) assert_string_equal(a[i].name, b[3 - i].name);
}

static void names_tell_the_kind(void **state) {
    (void)state;
    static const struct {
        const char *layer, *light;
        cau_layer_kind kind;
    } cases[] = {{"caustics_key", "key", CAU_LAYER_RADIANCE}, {"caustics_key_ind", "key", CAU_LAYER_INDIRECT},
        {"caustics_key_E", "key", CAU_LAYER_IRRADIANCE}, {"caustics_key_S", "key", CAU_LAYER_SEEN},
        {"caustics_key_err", "key", CAU_LAYER_ERROR}, {"caustics_key_ind_bias", "key", CAU_LAYER_BIAS}};
    char light[64];
    cau_layer_kind kind;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_true(layer_name_parse(cases[i].layer, light, &kind));
        assert_string_equal(light, cases[i].light);
        assert_int_equal(kind, cases[i].kind);
    }
    assert_false(layer_name_parse("caustics_", light, &kind));
    assert_false(layer_name_parse("Combined", light, &kind));
}

static void list_survives_json(void **state) {
    (void)state;
    LayerList list = {0}, back;
    CauError err = {0};
    assert_int_equal(layer_list_add(&list, "caustics_Key_001", "Key.001", CAU_LAYER_RADIANCE, &err), CAU_OK);
    assert_int_equal(
        layer_list_add(&list, "caustics_K_hl_ind", "K\xc3\xbchl \"1\"", CAU_LAYER_INDIRECT, &err), CAU_OK);
    char *json = layer_list_encode(&list);
    assert_non_null(json);
    assert_int_equal(layer_list_decode(&back, json, &err), CAU_OK);
    assert_int_equal(back.count, 2);
    assert_string_equal(back.entries[1].light, "K\xc3\xbchl \"1\"");
    assert_int_equal(back.entries[1].kind, CAU_LAYER_INDIRECT);
    free(json);
    layer_list_free(&list);
    layer_list_free(&back);
}

static void bad_lists_are_refused(void **state) {
    (void)state;
    static const char *const bad[] = {"", "{}", "[1]", "[{}]", "[{\"layer\":\"a\",\"light\":\"b\"}]",
        "[{\"layer\":\"a\",\"light\":\"b\",\"kind\":\"x\"}]",
        "[{\"layer\":\"a\",\"light\":\"b\",\"kind\":\"seen\",\"gain\":2}]",
        ("[{\"layer\":\"a\",\"light\":\"b\",\"kind\":\"seen\"},{\"layer\":\"a\",\"light\":\"c\",\"kind\":"
         "\"seen\"}]")};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        LayerList list;
        CauError err = {0};
        assert_int_equal(layer_list_decode(&list, bad[i], &err), CAU_ERROR_INPUT);
        assert_non_null(strstr(err.text, "caustics/layers"));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_short_plain_and_different),
        cmocka_unit_test(plain_names_stay),
        cmocka_unit_test(order_does_not_matter),
        cmocka_unit_test(names_tell_the_kind),
        cmocka_unit_test(list_survives_json),
        cmocka_unit_test(bad_lists_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
