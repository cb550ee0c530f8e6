// SPDX-License-Identifier: Apache-2.0
#include "bridge/picture.h"

#include <OpenImageIO/imageio.h>

#include <exception>

cau_result picture_write_png(
    const char *path, const char *shown, const uint8_t *rgb, size_t width, size_t height, CauError *err) {
    try {
        auto file = OIIO::ImageOutput::create("png");
        if (!file)
            return error_set(
                err, CAU_ERROR_RESOURCE, "cannot write \"%s\": %s", shown, OIIO::geterror().c_str());
        OIIO::ImageSpec spec(static_cast<int>(width), static_cast<int>(height), 3, OIIO::TypeDesc::UINT8);
        if (!file->open(path, spec) || !file->write_image(OIIO::TypeDesc::UINT8, rgb) || !file->close())
            return error_set(
                err, CAU_ERROR_RESOURCE, "cannot write \"%s\": %s", shown, file->geterror().c_str());
        return CAU_OK;
    } catch (const std::exception &e) {
        return error_set(err, CAU_ERROR_RESOURCE, "cannot write \"%s\": %s", shown, e.what());
    } catch (...) {
        return error_set(err, CAU_ERROR_INTERNAL, "cannot write \"%s\": unknown exception", shown);
    }
}
