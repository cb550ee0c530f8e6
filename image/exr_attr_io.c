/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_attr_io.h"

#include "core/checked.h"

#include <string.h>

/* Types whose memory is the file's bytes (all are packed, this library runs on little-endian machines only):
 * `direct` ones sit in the union itself, the others behind its pointer. */
typedef struct PlainType {
    exr_attribute_type_t type;
    size_t size;
    bool direct;
} PlainType;

static const PlainType plain_types[] = {
    {EXR_ATTR_COMPRESSION, 1, true},
    {EXR_ATTR_ENVMAP, 1, true},
    {EXR_ATTR_LINEORDER, 1, true},
    {EXR_ATTR_INT, 4, true},
    {EXR_ATTR_FLOAT, 4, true},
    {EXR_ATTR_DOUBLE, 8, true},
    {EXR_ATTR_BOX2I, sizeof(exr_attr_box2i_t), false},
    {EXR_ATTR_BOX2F, sizeof(exr_attr_box2f_t), false},
    {EXR_ATTR_CHROMATICITIES, sizeof(exr_attr_chromaticities_t), false},
    {EXR_ATTR_KEYCODE, sizeof(exr_attr_keycode_t), false},
    {EXR_ATTR_M33F, sizeof(exr_attr_m33f_t), false},
    {EXR_ATTR_M33D, sizeof(exr_attr_m33d_t), false},
    {EXR_ATTR_M44F, sizeof(exr_attr_m44f_t), false},
    {EXR_ATTR_M44D, sizeof(exr_attr_m44d_t), false},
    {EXR_ATTR_RATIONAL, sizeof(exr_attr_rational_t), false},
    {EXR_ATTR_TILEDESC, sizeof(exr_attr_tiledesc_t), false},
    {EXR_ATTR_TIMECODE, sizeof(exr_attr_timecode_t), false},
    {EXR_ATTR_V2I, sizeof(exr_attr_v2i_t), false},
    {EXR_ATTR_V2F, sizeof(exr_attr_v2f_t), false},
    {EXR_ATTR_V2D, sizeof(exr_attr_v2d_t), false},
    {EXR_ATTR_V3I, sizeof(exr_attr_v3i_t), false},
    {EXR_ATTR_V3F, sizeof(exr_attr_v3f_t), false},
    {EXR_ATTR_V3D, sizeof(exr_attr_v3d_t), false},
};

static const PlainType *plain_type(exr_attribute_type_t type) {
    for (size_t i = 0; i < sizeof plain_types / sizeof *plain_types; i++)
        if (plain_types[i].type == type) return &plain_types[i];
    return NULL;
}

static cau_result no_memory(const char *name, CauError *err) {
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the attribute \"%s\"", name);
}

static cau_result strings_from_core(ExrPart *part, const exr_attribute_t *attr, CauError *err) {
    const exr_attr_string_vector_t *v = attr->stringvector;
    size_t size = 0;
    for (int32_t i = 0; i < v->n_strings; i++) size += 4 + (size_t)v->strings[i].length;
    uint8_t *bytes = array_new(size, 1), *at = bytes;
    if (!bytes) return no_memory(attr->name, err);
    for (int32_t i = 0; i < v->n_strings; i++) {
        memcpy(at, &v->strings[i].length, 4);
        if (v->strings[i].length) memcpy(at + 4, v->strings[i].str, (size_t)v->strings[i].length);
        at += 4 + v->strings[i].length;
    }
    cau_result result = exr_attr_set(part, attr->name, attr->type_name, bytes, size, err);
    free(bytes);
    return result;
}

static cau_result preview_from_core(ExrPart *part, const exr_attribute_t *attr, CauError *err) {
    const exr_attr_preview_t *p = attr->preview;
    size_t pixels = (size_t)p->width * p->height * 4;
    uint8_t *bytes = array_new(pixels + 8, 1);
    if (!bytes) return no_memory(attr->name, err);
    memcpy(bytes, &p->width, 4);
    memcpy(bytes + 4, &p->height, 4);
    if (pixels) memcpy(bytes + 8, p->rgba, pixels);
    cau_result result = exr_attr_set(part, attr->name, attr->type_name, bytes, pixels + 8, err);
    free(bytes);
    return result;
}

cau_result exr_attr_from_core(ExrPart *part, const exr_attribute_t *attr, CauError *err) {
    const PlainType *plain = plain_type(attr->type);
    if (plain) {
        const void *data = plain->direct ? (const void *)&attr->uc : attr->rawptr;
        return exr_attr_set(part, attr->name, attr->type_name, data, plain->size, err);
    }
    switch (attr->type) {
    case EXR_ATTR_STRING:
        return exr_attr_set(
            part, attr->name, attr->type_name, attr->string->str, (size_t)attr->string->length, err);
    case EXR_ATTR_FLOAT_VECTOR:
        return exr_attr_set(part, attr->name, attr->type_name, attr->floatvector->arr,
            (size_t)attr->floatvector->length * 4, err);
    case EXR_ATTR_STRING_VECTOR:
        return strings_from_core(part, attr, err);
    case EXR_ATTR_PREVIEW:
        return preview_from_core(part, attr, err);
    case EXR_ATTR_OPAQUE:
        return exr_attr_set(
            part, attr->name, attr->type_name, attr->opaque->packed_data, (size_t)attr->opaque->size, err);
    default:
        return error_set(err, CAU_ERROR_INPUT,
            "the attribute \"%s\" has the type \"%s\", which is not one for a "
            "header of a flat picture",
            attr->name, attr->type_name);
    }
}

static exr_result_t strings_to_core(exr_context_t context, int index, const ExrAttr *attr) {
    const uint8_t *bytes = attr->data;
    size_t count = 0, at = 0;
    exr_result_t code = EXR_ERR_OUT_OF_MEMORY;
    char **texts = array_new(attr->size / 4 + 1, sizeof *texts);
    while (texts && at + 4 <= attr->size) {
        uint32_t length;
        memcpy(&length, bytes + at, 4);
        at += 4;
        if (length > attr->size - at) break;
        texts[count] = array_new((size_t)length + 1, 1);
        if (!texts[count]) goto done;
        memcpy(texts[count++], bytes + at, length);
        at += length;
    }
    if (texts)
        code = exr_attr_set_string_vector(
            context, index, attr->name, (int32_t)count, (const char **)(void *)texts);
done:
    for (size_t i = 0; texts && i < count; i++) free(texts[i]);
    free(texts);
    return code;
}

/* By reference: attr must live until the header is written. A copy by the library would end at a NUL. */
static exr_result_t string_to_core(exr_context_t context, int index, const ExrAttr *attr) {
    exr_attribute_t *made = NULL;
    exr_result_t code = exr_attr_declare_by_type(context, index, attr->name, "string", &made);
    if (code != EXR_ERR_SUCCESS) return code;
    *made->string = (exr_attr_string_t){.length = (int32_t)attr->size, .alloc_size = 0, .str = attr->data};
    return EXR_ERR_SUCCESS;
}

static exr_result_t preview_to_core(exr_context_t context, int index, const ExrAttr *attr) {
    exr_attr_preview_t preview = {0};
    if (attr->size < 8) return EXR_ERR_ATTR_SIZE_MISMATCH;
    memcpy(&preview.width, attr->data, 4);
    memcpy(&preview.height, (const uint8_t *)attr->data + 4, 4);
    preview.rgba = (const uint8_t *)attr->data + 8;
    return exr_attr_set_preview(context, index, attr->name, &preview);
}

exr_result_t exr_attr_to_core(exr_context_t context, int index, const ExrAttr *attr) {
    if (strcmp(attr->type, "string") == 0) return string_to_core(context, index, attr);
    if (strcmp(attr->type, "stringvector") == 0) return strings_to_core(context, index, attr);
    if (strcmp(attr->type, "preview") == 0) return preview_to_core(context, index, attr);
    if (strcmp(attr->type, "floatvector") == 0)
        return exr_attr_set_float_vector(context, index, attr->name, (int32_t)(attr->size / 4), attr->data);
    exr_attribute_t *made = NULL;
    exr_result_t code = exr_attr_declare_by_type(context, index, attr->name, attr->type, &made);
    if (code != EXR_ERR_SUCCESS) return code;
    const PlainType *plain = plain_type(made->type);
    if (plain) {
        if (plain->size != attr->size) return EXR_ERR_ATTR_SIZE_MISMATCH;
        memcpy(plain->direct ? (void *)&made->uc : made->rawptr, attr->data, attr->size);
        return EXR_ERR_SUCCESS;
    }
    return exr_attr_set_user(context, index, attr->name, attr->type, (int32_t)attr->size, attr->data);
}
