// SPDX-License-Identifier: Apache-2.0
#include "bridge/colour.h"

#include <OpenColorIO/OpenColorIO.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <sstream>
#include <string>

namespace OCIO = OCIO_NAMESPACE;

struct Colour {
    OCIO::ConstConfigRcPtr config;
    std::string origin;
};

struct ColourView {
    OCIO::ConstCPUProcessorRcPtr processor;
};

namespace {

// The caller is in a catch block.
cau_result report(const Colour *colour, const char *doing, CauError *err) {
    try {
        throw;
    } catch (const std::bad_alloc &) {
        return error_set(err, CAU_ERROR_RESOURCE, "cannot %s: out of memory", doing);
    } catch (const std::exception &e) {
        return error_set(err, CAU_ERROR_INPUT, "%s: cannot %s: %s", colour->origin.c_str(), doing, e.what());
    } catch (...) {
        return error_set(err, CAU_ERROR_INTERNAL, "cannot %s: unknown exception", doing);
    }
}

OCIO::ConstColorSpaceRcPtr find(const Colour *colour, const char *name) {
    return colour->config->getColorSpace(name);
}

struct Matrix {
    double m[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
};

Matrix product(const Matrix &a, const Matrix &b) {
    Matrix out;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            out.m[3 * r + c] =
                a.m[3 * r] * b.m[c] + a.m[3 * r + 1] * b.m[3 + c] + a.m[3 * r + 2] * b.m[6 + c];
    return out;
}

bool inverse(const Matrix &a, Matrix *out) {
    const double *m = a.m;
    double c0 = m[4] * m[8] - m[5] * m[7], c1 = m[5] * m[6] - m[3] * m[8], c2 = m[3] * m[7] - m[4] * m[6];
    double determinant = m[0] * c0 + m[1] * c1 + m[2] * c2;
    if (!(std::fabs(determinant) > 0)) return false;
    const double adjugate[9] = {c0, m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4], c1,
        m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5], c2, m[1] * m[6] - m[0] * m[7],
        m[0] * m[4] - m[1] * m[3]};
    for (int i = 0; i < 9; i++) out->m[i] = adjugate[i] / determinant;
    return true;
}

// False for anything but a matrix on RGB without an offset.
bool matrix_of(const OCIO::ConstTransformRcPtr &transform, Matrix *out) {
    auto matrix = OCIO::DynamicPtrCast<const OCIO::MatrixTransform>(transform);
    if (!matrix) return false;
    double m44[16], offset[4];
    matrix->getMatrix(m44);
    matrix->getOffset(offset);
    for (int i = 0; i < 3; i++)
        if (offset[i] != 0 || m44[4 * i + 3] != 0) return false;
    Matrix forward;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) forward.m[3 * r + c] = m44[4 * r + c];
    if (matrix->getDirection() == OCIO::TRANSFORM_DIR_INVERSE) return inverse(forward, out);
    *out = forward;
    return true;
}

bool all_matrices(const OCIO::ConstProcessorRcPtr &processor, Matrix *out) {
    OCIO::ConstGroupTransformRcPtr group = processor->createGroupTransform();
    *out = Matrix();
    for (int i = 0; i < group->getNumTransforms(); i++) {
        Matrix step;
        if (!matrix_of(group->getTransform(i), &step)) return false;
        *out = product(step, *out);
    }
    return true;
}

// In double, straight from the configuration's matrices; OCIO itself would apply them in single precision.
// Curves that undo each other (both spaces logarithmic in the same way) vanish in the optimised form.
bool linear_matrix(const OCIO::ConstProcessorRcPtr &processor, Matrix *out) {
    return all_matrices(processor, out) ||
           all_matrices(processor->getOptimizedProcessor(OCIO::OPTIMIZATION_LOSSLESS), out);
}

bool is_linear(const Colour *colour, const OCIO::ConstColorSpaceRcPtr &space) {
    OCIO::ConstTransformRcPtr to = space->getTransform(OCIO::COLORSPACE_DIR_TO_REFERENCE);
    OCIO::ConstTransformRcPtr from = space->getTransform(OCIO::COLORSPACE_DIR_FROM_REFERENCE);
    Matrix unused;
    if (to) return linear_matrix(colour->config->getProcessor(to), &unused);
    return !from || linear_matrix(colour->config->getProcessor(from), &unused);
}

} // namespace

cau_result colour_open(Colour **out, const char *config, CauError *err) {
    *out = nullptr;
    Colour *colour = nullptr;
    const char *environment = std::getenv("OCIO");
    const char *path = config ? config : (environment && environment[0] ? environment : "builtin");
    try {
        colour = new Colour;
        if (std::strcmp(path, "builtin") == 0) {
            colour->origin = "the built-in colour configuration";
            std::istringstream text(colour_builtin_config);
            colour->config = OCIO::Config::CreateFromStream(text);
        } else {
            colour->origin = std::string("the colour configuration \"") + path + "\"";
            if (!config) colour->origin += " (from $OCIO)";
            colour->config = OCIO::Config::CreateFromFile(path);
        }
        colour->config->validate();
        *out = colour;
        return CAU_OK;
    } catch (const std::exception &e) {
        error_set(err, CAU_ERROR_INPUT, "%s cannot be used: %s; mend it, or choose --ocio builtin",
            colour ? colour->origin.c_str() : "the colour configuration", e.what());
    } catch (...) {
        error_set(err, CAU_ERROR_INPUT, "the colour configuration \"%s\" cannot be used", path);
    }
    delete colour;
    return CAU_ERROR_INPUT;
}

void colour_close(Colour **colour) {
    delete *colour;
    *colour = nullptr;
}

const char *colour_origin(const Colour *colour) { return colour->origin.c_str(); }

const char *colour_resolve(const Colour *colour, const char *name) {
    try {
        OCIO::ConstColorSpaceRcPtr space = find(colour, name);
        return space ? space->getName() : nullptr; // the configuration owns the space, and its name
    } catch (...) {
        return nullptr;
    }
}

size_t colour_name_count(const Colour *colour) {
    try {
        return static_cast<size_t>(
            colour->config->getNumColorSpaces(OCIO::SEARCH_REFERENCE_SPACE_ALL, OCIO::COLORSPACE_ALL));
    } catch (...) {
        return 0;
    }
}

const char *colour_name_at(const Colour *colour, size_t index) {
    try {
        return colour->config->getColorSpaceNameByIndex(
            OCIO::SEARCH_REFERENCE_SPACE_ALL, OCIO::COLORSPACE_ALL, static_cast<int>(index));
    } catch (...) {
        return "";
    }
}

const char *colour_alias_at(const Colour *colour, const char *name, size_t index) {
    try {
        OCIO::ConstColorSpaceRcPtr space = find(colour, name);
        return space && index < space->getNumAliases() ? space->getAlias(index) : nullptr;
    } catch (...) {
        return nullptr;
    }
}

ColourKind colour_kind(const Colour *colour, const char *name) {
    try {
        OCIO::ConstColorSpaceRcPtr space = find(colour, name);
        if (!space || space->isData()) return COLOUR_DATA;
        if (space->getReferenceSpaceType() == OCIO::REFERENCE_SPACE_DISPLAY) return COLOUR_DISPLAY;
        return is_linear(colour, space) ? COLOUR_LINEAR : COLOUR_ENCODED;
    } catch (...) {
        return COLOUR_ENCODED; // a space whose files are missing is not one to add light in
    }
}

cau_result colour_matrix(
    const Colour *colour, const char *from, const char *to, double matrix[9], bool *same, CauError *err) {
    try {
        Matrix found;
        const char *source = find(colour, from)->getName(), *target = find(colour, to)->getName();
        *same = std::strcmp(source, target) == 0;
        if (!*same) {
            OCIO::ConstProcessorRcPtr processor = colour->config->getProcessor(from, to);
            if (!linear_matrix(processor, &found))
                return error_set(err, CAU_ERROR_INPUT,
                    "%s: \"%s\" to \"%s\" is not a matrix, so light cannot be added", colour->origin.c_str(),
                    from, to);
            *same = std::memcmp(found.m, Matrix().m, sizeof found.m) == 0;
        }
        std::memcpy(matrix, found.m, sizeof found.m);
        return CAU_OK;
    } catch (...) {
        return report(colour, "convert between colour spaces", err);
    }
}

static std::string display_list(const OCIO::ConstConfigRcPtr &config) {
    std::string list;
    for (int i = 0; i < config->getNumDisplays(); i++)
        list += (i ? ", " : "") + std::string(config->getDisplay(i));
    return list;
}

static std::string view_list(const OCIO::ConstConfigRcPtr &config, const char *display) {
    std::string list;
    for (int i = 0; i < config->getNumViews(display); i++)
        list += (i ? ", " : "") + std::string(config->getView(display, i));
    return list;
}

static std::string look_list(const OCIO::ConstConfigRcPtr &config) {
    std::string list;
    for (int i = 0; i < config->getNumLooks(); i++)
        list += (i ? ", " : "") + std::string(config->getLookNameByIndex(i));
    return list.empty() ? "none" : list;
}

static bool has_display(const OCIO::ConstConfigRcPtr &config, const char *name) {
    for (int i = 0; i < config->getNumDisplays(); i++)
        if (std::strcmp(config->getDisplay(i), name) == 0) return true;
    return false;
}

static bool has_view(const OCIO::ConstConfigRcPtr &config, const char *display, const char *name) {
    for (int i = 0; i < config->getNumViews(display); i++)
        if (std::strcmp(config->getView(display, i), name) == 0) return true;
    return false;
}

cau_result colour_view_open(ColourView **out, const Colour *colour, const char *space, const char *display,
    const char *view, const char *look, CauError *err) {
    *out = nullptr;
    try {
        const OCIO::ConstConfigRcPtr &config = colour->config;
        std::string shown = display ? display : config->getDefaultDisplay();
        if (!has_display(config, shown.c_str()))
            return error_set(err, CAU_ERROR_INPUT, "%s has no display \"%s\", only: %s",
                colour->origin.c_str(), shown.c_str(), display_list(config).c_str());
        std::string seen = view ? view : config->getDefaultView(shown.c_str());
        if (!has_view(config, shown.c_str(), seen.c_str()))
            return error_set(err, CAU_ERROR_INPUT, "%s: display \"%s\" has no view \"%s\", only: %s",
                colour->origin.c_str(), shown.c_str(), seen.c_str(),
                view_list(config, shown.c_str()).c_str());
        auto transform = OCIO::DisplayViewTransform::Create();
        transform->setSrc(space);
        transform->setDisplay(shown.c_str());
        transform->setView(seen.c_str());
        auto group = OCIO::GroupTransform::Create();
        if (look) {
            if (!config->getLook(look))
                return error_set(err, CAU_ERROR_INPUT, "%s has no look \"%s\", only: %s",
                    colour->origin.c_str(), look, look_list(config).c_str());
            auto before = OCIO::LookTransform::Create();
            before->setSrc(space);
            before->setDst(space);
            before->setLooks(look);
            group->appendTransform(before);
        }
        group->appendTransform(transform);
        auto made = std::make_unique<ColourView>();
        made->processor = config->getProcessor(group)->getDefaultCPUProcessor();
        *out = made.release();
        return CAU_OK;
    } catch (...) {
        return report(colour, "show the picture", err);
    }
}

void colour_view_close(ColourView **view) {
    delete *view;
    *view = nullptr;
}

cau_result colour_view_apply(const ColourView *view, float *rgb, size_t width, size_t height, CauError *err) {
    try {
        OCIO::PackedImageDesc picture(rgb, static_cast<long>(width), static_cast<long>(height), 3);
        view->processor->apply(picture);
        return CAU_OK;
    } catch (const std::exception &e) {
        return error_set(err, CAU_ERROR_INPUT, "cannot show the picture: %s", e.what());
    } catch (...) {
        return error_set(err, CAU_ERROR_INTERNAL, "cannot show the picture: unknown exception");
    }
}
