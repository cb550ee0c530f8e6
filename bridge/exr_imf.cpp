// SPDX-License-Identifier: Apache-2.0
#include "bridge/exr_imf.h"

#include <ImfAttribute.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOpaqueAttribute.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfTileDescription.h>
#include <ImfTiledOutputPart.h>
#include <ImfVersion.h>

#include <cerrno>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <memory>
#include <new>
#include <string>
#include <unistd.h>
#include <vector>

namespace {

// The destructors of the library swallow errors, so the stream remembers the first one.
class FileOut : public Imf::OStream {
  public:
    explicit FileOut(const char *path)
        : Imf::OStream(path), fd_(open(path, O_WRONLY | O_TRUNC | O_CLOEXEC | O_NOFOLLOW)),
          error_(fd_ < 0 ? errno : 0) {}
    ~FileOut() override {
        if (fd_ >= 0) ::close(fd_);
    }
    FileOut(const FileOut &) = delete;
    FileOut &operator=(const FileOut &) = delete;
    void write(const char bytes[], int count) override {
        for (int done = 0; done < count;) {
            ssize_t n = pwrite(fd_, bytes + done, static_cast<size_t>(count - done), static_cast<off_t>(at_));
            if (n < 0 && errno == EINTR) continue;
            if (n <= 0) {
                if (!error_) error_ = n < 0 ? errno : ENOSPC;
                throw std::runtime_error(strerror(error_));
            }
            done += static_cast<int>(n);
            at_ += static_cast<uint64_t>(n);
        }
    }
    uint64_t tellp() override { return at_; }
    void seekp(uint64_t to) override { at_ = to; }
    int error() const { return error_; }

  private:
    int fd_;
    uint64_t at_ = 0;
    int error_;
};

class BytesIn : public Imf::IStream {
  public:
    BytesIn(const void *bytes, size_t size)
        : Imf::IStream("attribute"), bytes_(static_cast<const char *>(bytes)), size_(size) {}
    bool read(char to[], int count) override {
        if (static_cast<size_t>(count) > size_ - at_) throw std::runtime_error("attribute is too short");
        memcpy(to, bytes_ + at_, static_cast<size_t>(count));
        at_ += static_cast<size_t>(count);
        return at_ < size_;
    }
    uint64_t tellg() override { return at_; }
    void seekg(uint64_t to) override { at_ = static_cast<size_t>(to); }

  private:
    const char *bytes_;
    size_t size_, at_ = 0;
};

cau_result report(const char *doing, const char *path, CauError *err) {
    try {
        throw;
    } catch (const std::bad_alloc &) {
        // The sizes that the library allocates when reading are those that the file claims.
        if (strcmp(doing, "read") == 0)
            return error_set(err, CAU_ERROR_INPUT,
                "cannot read \"%s\": it asks for more memory than there is: the file is damaged", path);
        return error_set(err, CAU_ERROR_RESOURCE, "cannot %s \"%s\": out of memory", doing, path);
    } catch (const std::exception &e) {
        return error_set(err, CAU_ERROR_INPUT, "cannot %s \"%s\": %s", doing, path, e.what());
    } catch (...) {
        return error_set(err, CAU_ERROR_INTERNAL, "cannot %s \"%s\": unknown exception", doing, path);
    }
}

// A frame buffer over rows in the layout of the file.
Imf::FrameBuffer frame_buffer(const ExrPart *part, const ExrRows *rows) {
    Imf::FrameBuffer buffer;
    for (size_t c = 0; c < part->channel_count; c++) {
        Imath::V2i origin(part->data_window.x0, rows->y0);
        buffer.insert(
            part->channels[c].name, Imf::Slice::Make(static_cast<Imf::PixelType>(part->channels[c].type),
                                        rows->bytes + exr_channel_offset(part, c), origin,
                                        part->data_window.x1 - part->data_window.x0 + 1, 1,
                                        exr_type_bytes(part->channels[c].type), rows->row_bytes));
    }
    return buffer;
}

void add_attribute(Imf::Header *header, const ExrAttr *attr) {
    std::unique_ptr<Imf::Attribute> made;
    if (Imf::Attribute::knownType(attr->type))
        made.reset(Imf::Attribute::newAttribute(attr->type));
    else
        made.reset(new Imf::OpaqueAttribute(attr->type));
    BytesIn bytes(attr->data, attr->size);
    made->readValueFrom(bytes, static_cast<int>(attr->size), Imf::EXR_VERSION);
    header->insert(attr->name, *made);
}

Imath::Box2i imf_box(ExrBox b) { return Imath::Box2i(Imath::V2i(b.x0, b.y0), Imath::V2i(b.x1, b.y1)); }

Imf::Header imf_header(const ExrPart *part) {
    Imf::Header header(imf_box(part->display_window), imf_box(part->data_window), part->pixel_aspect,
        Imath::V2f(part->screen_center[0], part->screen_center[1]), part->screen_width,
        static_cast<Imf::LineOrder>(part->order), static_cast<Imf::Compression>(part->codec));
    for (size_t a = 0; a < part->attr_count; a++) add_attribute(&header, &part->attrs[a]);
    for (size_t c = 0; c < part->channel_count; c++) {
        const ExrChannel *channel = &part->channels[c];
        header.channels().insert(
            channel->name, Imf::Channel(static_cast<Imf::PixelType>(channel->type), channel->x_sampling,
                               channel->y_sampling, channel->p_linear != 0));
    }
    if (part->name) header.setName(part->name);
    header.setType(part->tiled ? Imf::TILEDIMAGE : Imf::SCANLINEIMAGE);
    if (part->tiled) header.setTileDescription(Imf::TileDescription(part->tile_width, part->tile_height));
    return header;
}

} // namespace

struct ImfReader {
    std::string path;
    std::unique_ptr<Imf::MultiPartInputFile> file;
};

struct ImfWriter {
    std::string shown;
    const ExrHeader *header = nullptr;
    std::unique_ptr<FileOut> stream; // outlives the file
    std::unique_ptr<Imf::MultiPartOutputFile> file;
};

cau_result imf_reader_open(ImfReader **out, const char *path, CauError *err) {
    *out = nullptr;
    try {
        auto reader = std::make_unique<ImfReader>();
        reader->path = path;
        reader->file = std::make_unique<Imf::MultiPartInputFile>(path, 0, false);
        *out = reader.release();
        return CAU_OK;
    } catch (...) {
        return report("read", path, err);
    }
}

void imf_reader_close(ImfReader **reader) {
    delete *reader;
    *reader = nullptr;
}

cau_result imf_reader_rows(
    ImfReader *reader, size_t part, const ExrPart *description, const ExrRows *rows, CauError *err) {
    try {
        Imf::InputPart input(*reader->file, static_cast<int>(part));
        if (input.header().dataWindow() != imf_box(description->data_window))
            return error_set(err, CAU_ERROR_INPUT, "\"%s\" changed while it was read", reader->path.c_str());
        input.setFrameBuffer(frame_buffer(description, rows));
        input.readPixels(rows->y0, rows->y1);
        return CAU_OK;
    } catch (...) {
        return report("read", reader->path.c_str(), err);
    }
}

static cau_result write_failed(const ImfWriter *writer, CauError *err) {
    if (writer->stream && writer->stream->error())
        return error_set(err, CAU_ERROR_RESOURCE,
            "cannot write \"%s\": %s; free some space or name another folder", writer->shown.c_str(),
            strerror(writer->stream->error()));
    return report("write", writer->shown.c_str(), err);
}

cau_result imf_writer_open(
    ImfWriter **out, const char *path, const char *shown, const ExrHeader *header, CauError *err) {
    *out = nullptr;
    std::unique_ptr<ImfWriter> writer;
    try {
        writer = std::make_unique<ImfWriter>();
        writer->shown = shown;
        writer->header = header;
        writer->stream = std::make_unique<FileOut>(path);
        std::vector<Imf::Header> headers;
        for (size_t i = 0; i < header->part_count; i++) headers.push_back(imf_header(&header->parts[i]));
        writer->file = std::make_unique<Imf::MultiPartOutputFile>(
            *writer->stream, headers.data(), static_cast<int>(headers.size()), false, 0);
        *out = writer.release();
        return CAU_OK;
    } catch (...) {
        return writer ? write_failed(writer.get(), err) : report("write", shown, err);
    }
}

cau_result imf_writer_rows(ImfWriter *writer, size_t part, const ExrRows *rows, CauError *err) {
    const ExrPart *description = &writer->header->parts[part];
    try {
        Imf::FrameBuffer buffer = frame_buffer(description, rows);
        if (!description->tiled) {
            Imf::OutputPart output(*writer->file, static_cast<int>(part));
            output.setFrameBuffer(buffer);
            output.writePixels(rows->y1 - rows->y0 + 1);
            return CAU_OK;
        }
        Imf::TiledOutputPart output(*writer->file, static_cast<int>(part));
        int height = static_cast<int>(description->tile_height);
        int first = (rows->y0 - description->data_window.y0) / height,
            last = (rows->y1 - description->data_window.y0) / height;
        output.setFrameBuffer(buffer);
        output.writeTiles(0, output.numXTiles(0) - 1, first, last, 0);
        return CAU_OK;
    } catch (...) {
        return write_failed(writer, err);
    }
}

cau_result imf_writer_close(ImfWriter **writer, CauError *err) {
    ImfWriter *w = *writer;
    cau_result result = CAU_OK;
    if (!w) return result;
    try {
        w->file.reset(); // writes the chunk tables, and keeps silent if it cannot
    } catch (...) {
        result = report("finish", w->shown.c_str(), err);
    }
    if (result == CAU_OK && w->stream && w->stream->error())
        result = error_set(err, CAU_ERROR_RESOURCE, "cannot write \"%s\": %s", w->shown.c_str(),
            strerror(w->stream->error()));
    delete w;
    *writer = nullptr;
    return result;
}
