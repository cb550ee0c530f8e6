/* SPDX-License-Identifier: Apache-2.0 */
#include "image/colour_tag.h"

#include "caustics/layers.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { OTHER_NAMES = 6 };

typedef struct KnownSpace {
    const char *id;
    const char *others[OTHER_NAMES];
    float xy[8]; /* red, green, blue, white; 0 when the space is not told by its primaries */
} KnownSpace;

static const float tolerance = 0.001f;

static const KnownSpace known[] = {
    {"lin_rec709_scene",
        {"Linear Rec.709", "Linear Rec.709 (sRGB)", "lin_rec709", "lin_srgb", "Utility - Linear - sRGB"},
        {.64f, .33f, .3f, .6f, .15f, .06f, .3127f, .329f}},
    {"lin_ap1_scene", {"ACEScg", "lin_ap1", "ACES - ACEScg", "Linear ACEScg"},
        {.713f, .293f, .165f, .83f, .128f, .044f, .32168f, .33767f}},
    {"lin_ap0_scene", {"ACES2065-1", "lin_ap0", "ACES - ACES2065-1", "Linear ACES"},
        {.7347f, .2653f, 0, 1, .0001f, -.077f, .32168f, .33767f}},
    {"lin_p3d65_scene", {"Linear P3-D65", "lin_p3d65", "Linear DCI-P3 D65", "Utility - Linear - P3-D65"},
        {.68f, .32f, .265f, .69f, .15f, .06f, .3127f, .329f}},
    {"lin_rec2020_scene", {"Linear Rec.2020", "lin_rec2020", "Utility - Linear - Rec.2020"},
        {.708f, .292f, .17f, .797f, .131f, .046f, .3127f, .329f}},
    {"lin_adobergb_scene", {"Linear AdobeRGB", "lin_adobergb", "Utility - Linear - Adobe RGB"},
        {.64f, .33f, .21f, .71f, .15f, .06f, .3127f, .329f}},
    {"srgb_rec709_scene", {"sRGB Texture", "sRGB - Texture", "srgb_tx", "Utility - sRGB - Texture"}, {0}},
    {"g24_rec709_scene", {"Gamma 2.4 Rec.709 - Texture", "Gamma 2.4 Rec.709 Texture"}, {0}},
    {"data", {"Raw", "Utility - Raw", "Non-Color"}, {0}},
};
enum { KNOWN = sizeof known / sizeof *known };

size_t colour_id_count(void) { return KNOWN; }
const char *colour_id_at(size_t index) { return known[index].id; }
const char *colour_id_other_name(size_t index, size_t which) {
    return which < OTHER_NAMES ? known[index].others[which] : NULL;
}

static void set_id(ColourTag *tag, ColourTagSource source, const char *id) {
    tag->source = source;
    size_t i = 0;
    for (; id[i] && i < COLOUR_ID_MAX; i++) tag->id[i] = (char)tolower((unsigned char)id[i]);
    tag->id[i] = '\0';
}

static bool read_flag(ColourTag *tag, const ExrPart *part) {
    int32_t flag;
    if (!exr_attr_int32(exr_attr_find(part, "acesImageContainerFlag"), &flag) || flag != 1) return false;
    set_id(tag, COLOUR_TAG_ACES, "lin_ap0_scene");
    return true;
}

static bool read_id(ColourTag *tag, const ExrPart *part) {
    char *text = exr_attr_text(exr_attr_find_any_case(part, CAU_ATTRIBUTE_COLOR_ID));
    if (!text) return false;
    bool says = text[0] && strcasecmp(text, "unknown") != 0;
    if (says) set_id(tag, COLOUR_TAG_ID, text);
    free(text);
    return says;
}

static const KnownSpace *space_of(const ExrAttr *attr) {
    float xy[8];
    if (!attr || strcmp(attr->type, "chromaticities") != 0 || attr->size != sizeof xy) return NULL;
    memcpy(xy, attr->data, sizeof xy);
    for (int k = 0; k < KNOWN; k++) {
        bool match = known[k].xy[0] > 0;
        for (int i = 0; match && i < 8; i++) match = fabsf(xy[i] - known[k].xy[i]) <= tolerance;
        if (match) return &known[k];
    }
    return NULL;
}

static bool read_chromaticities(ColourTag *tag, const ExrPart *part) {
    const ExrAttr *attr = exr_attr_find(part, "chromaticities");
    const KnownSpace *space = space_of(attr);
    if (space) set_id(tag, COLOUR_TAG_CHROMATICITIES, space->id);
    tag->unknown_chromaticities = attr && !space;
    return attr != NULL; /* unknown ones too are an answer: what comes after is a guess */
}

static bool read_blender(ColourTag *tag, const ExrPart *part) {
    bool signature = exr_attr_find(part, "BlenderMultiChannel") != NULL;
    for (size_t a = 0; !signature && a < part->attr_count; a++)
        signature = strncmp(part->attrs[a].name, "cycles.", 7) == 0;
    if (signature) set_id(tag, COLOUR_TAG_BLENDER, "lin_rec709_scene");
    return signature;
}

/* Each part may say that it holds no colour; that says nothing of the others. */
static bool is_data(const ExrPart *part) {
    ColourTag tag;
    return read_id(&tag, part) && strcmp(tag.id, "data") == 0;
}

void colour_tag_read(ColourTag *out, const ExrHeader *header, size_t part) {
    static bool (*const readers[])(ColourTag *, const ExrPart *) = {
        read_flag, read_id, read_chromaticities, read_blender};
    bool first_too = part && !is_data(&header->parts[0]);
    *out = (ColourTag){0};
    for (size_t i = 0; i < sizeof readers / sizeof *readers; i++) {
        if (readers[i](out, &header->parts[part])) return;
        if ((first_too || (part && readers[i] == read_blender)) && readers[i](out, &header->parts[0])) return;
    }
}

bool colour_tag_other(ColourTag *out, const ExrHeader *header, size_t part, const ColourTag *believed) {
    static bool (*const readers[])(ColourTag *, const ExrPart *) = {read_id, read_chromaticities};
    for (size_t i = 0; i < sizeof readers / sizeof *readers; i++) {
        const ExrPart *from = &header->parts[part];
        *out = (ColourTag){0};
        if (!readers[i](out, from) && (is_data(&header->parts[0]) || !readers[i](out, &header->parts[0])))
            continue;
        if (out->source > believed->source && strcmp(out->id, believed->id) != 0) return true;
    }
    return false;
}

/* Takes away what says something other than `id`; whether there was an interchange name among it. */
static bool remove_contradictions(ExrPart *part, const char *id) {
    const ExrAttr *attr;
    bool named = false;
    while ((attr = exr_attr_find_any_case(part, CAU_ATTRIBUTE_COLOR_ID))) {
        char *text = exr_attr_text(attr);
        bool agrees = text && id && strcasecmp(text, id) == 0;
        free(text);
        if (agrees) break;
        exr_attr_remove(part, attr->name);
        named = true;
    }
    const KnownSpace *space = space_of(exr_attr_find(part, "chromaticities"));
    if (!space || !id || strcmp(space->id, id) != 0) exr_attr_remove(part, "chromaticities");
    int32_t flag;
    if (exr_attr_int32(exr_attr_find(part, "acesImageContainerFlag"), &flag) && flag == 1 &&
        (!id || strcmp(id, "lin_ap0_scene") != 0))
        exr_attr_remove(part, "acesImageContainerFlag");
    return named;
}

/* In the first part, where readers look; in the target's own where the first holds no colour. */
static cau_result set_id_of(ExrHeader *header, size_t part, const char *id, CauError *err) {
    ExrPart *to = &header->parts[part && is_data(&header->parts[0]) ? part : 0];
    const ExrAttr *silent = exr_attr_find_any_case(to, CAU_ATTRIBUTE_COLOR_ID);
    if (silent) exr_attr_remove(to, silent->name); /* "unknown" */
    return exr_attr_set_text(to, CAU_ATTRIBUTE_COLOR_ID, id, err);
}

cau_result colour_tag_add(ExrHeader *header, size_t part, const char *id, CauError *err) {
    ColourTag there;
    if (read_id(&there, &header->parts[part])) return CAU_OK;
    const ExrAttr *silent = exr_attr_find_any_case(&header->parts[part], CAU_ATTRIBUTE_COLOR_ID);
    if (silent) exr_attr_remove(&header->parts[part], silent->name);
    if (!is_data(&header->parts[0]) && read_id(&there, &header->parts[0])) return CAU_OK;
    return set_id_of(header, part, id, err);
}

cau_result colour_tag_replace(ExrHeader *header, size_t part, const char *id, CauError *err) {
    for (size_t i = 0; i < header->part_count; i++) {
        if (i != part && is_data(&header->parts[i])) {
            /* All parts of a file must have the same chromaticities, or none. */
            const KnownSpace *space = space_of(exr_attr_find(&header->parts[i], "chromaticities"));
            if (!space || !id || strcmp(space->id, id) != 0)
                exr_attr_remove(&header->parts[i], "chromaticities");
            continue;
        }
        bool named = remove_contradictions(&header->parts[i], id);
        if (named && id) CAU_TRY(exr_attr_set_text(&header->parts[i], CAU_ATTRIBUTE_COLOR_ID, id, err));
    }
    return id ? colour_tag_add(header, part, id, err) : CAU_OK;
}
