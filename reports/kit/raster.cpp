#include "reports/kit/raster.hpp"

#include <cairo.h>
#include <librsvg/rsvg.h>
#include <openssl/evp.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <memory>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::reports::detail {
namespace {

void append_bytes(png_structp png, png_bytep data, png_size_t length) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), length);
}

[[noreturn]] void png_failed(png_structp, png_const_charp message) {
  throw NumericalError(std::string("PNG: ") + message);
}
void png_warned(png_structp, png_const_charp) {}

/// Owns libpng's write structure; libpng calls png_failed, which throws through its C frames (Debian builds
/// libpng with unwind tables, and nothing there needs cleaning up but what this destructor frees).
struct PngWriter {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, png_failed, png_warned);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
};

std::string encode(int width, int height, int colour_type, int bytes_a_pixel, const std::vector<std::uint8_t>& pixels,
                   const std::array<std::array<std::uint8_t, 3>, 256>* palette) {
  KLANG_CHECK(width > 0 && height > 0 &&
                  pixels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                                       static_cast<std::size_t>(bytes_a_pixel),
              "image size and pixels agree");
  std::string bytes;
  PngWriter writer;
  if (!writer.info) throw NumericalError("PNG: out of memory");
  png_set_write_fn(writer.png, &bytes, append_bytes, nullptr);
  png_set_compression_level(writer.png, 7);
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8,
               colour_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (palette) {
    std::array<png_color, 256> colours;
    for (std::size_t i = 0; i < 256; ++i) colours[i] = {(*palette)[i][0], (*palette)[i][1], (*palette)[i][2]};
    png_set_PLTE(writer.png, writer.info, colours.data(), 256);
    png_set_filter(writer.png, 0, PNG_FILTER_NONE);
  }
  png_write_info(writer.png, writer.info);
  const std::size_t stride = static_cast<std::size_t>(width) * static_cast<std::size_t>(bytes_a_pixel);
  for (int row = 0; row < height; ++row) {
    png_write_row(writer.png, const_cast<png_bytep>(pixels.data() + static_cast<std::size_t>(row) * stride));
  }
  png_write_end(writer.png, nullptr);
  return bytes;
}

double linear_to_srgb(double c) {
  c = std::clamp(c, 0.0, 1.0);
  return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
}

/// sRGB (0 to 1) of a colour in Oklab. Source: Ottosson 2020, "A perceptual color space for image
/// processing".
std::array<double, 3> from_oklab(double lightness, double a, double b) {
  const double l = std::pow(lightness + 0.3963377774 * a + 0.2158037573 * b, 3);
  const double m = std::pow(lightness - 0.1055613458 * a - 0.0638541728 * b, 3);
  const double s = std::pow(lightness - 0.0894841775 * a - 1.2914855480 * b, 3);
  return {linear_to_srgb(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          linear_to_srgb(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          linear_to_srgb(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

std::array<std::array<std::uint8_t, 3>, 256> make_heat_palette() {
  // Lightness rises evenly; hue turns from blue-violet through red and orange to yellow, chroma is largest
  // half-way.
  std::array<std::array<std::uint8_t, 3>, 256> palette;
  constexpr double kPiHere = 3.14159265358979323846;
  for (int i = 0; i < 256; ++i) {
    const double t = i / 255.0;
    const double lightness = 0.13 + 0.84 * t;
    const double hue = (285.0 + 180.0 * t) * kPiHere / 180.0;
    double chroma = 0.185 * std::pow(std::sin(kPiHere * (0.06 + 0.80 * t)), 1.2);
    // Back towards grey until the colour exists on a screen.
    for (int k = 0; k < 60; ++k) {
      const double a = chroma * std::cos(hue), b = chroma * std::sin(hue);
      const auto rgb = from_oklab(lightness, a, b);
      bool inside = true;
      for (const double c : rgb) inside = inside && c > 1e-4 && c < 0.9999;
      if (inside) break;
      chroma *= 0.96;
    }
    const auto rgb = from_oklab(lightness, chroma * std::cos(hue), chroma * std::sin(hue));
    for (std::size_t c = 0; c < 3; ++c) {
      palette[static_cast<std::size_t>(i)][c] = static_cast<std::uint8_t>(std::lround(255 * rgb[c]));
    }
  }
  return palette;
}

}  // namespace

const std::array<std::array<std::uint8_t, 3>, 256>& heat_palette() {
  static const auto palette = make_heat_palette();
  return palette;
}

std::string png_bytes(const IndexedImage& image, const std::array<std::array<std::uint8_t, 3>, 256>& palette) {
  return encode(image.width, image.height, PNG_COLOR_TYPE_PALETTE, 1, image.pixels, &palette);
}

std::string png_bytes(const RgbaImage& image) {
  return encode(image.width, image.height, PNG_COLOR_TYPE_RGB_ALPHA, 4, image.pixels, nullptr);
}

std::string png_of_svg(std::string_view svg, double scale) {
  struct ObjectFree {
    void operator()(void* object) const { g_object_unref(object); }
  };
  GError* error = nullptr;
  const std::unique_ptr<RsvgHandle, ObjectFree> handle(
      rsvg_handle_new_from_data(reinterpret_cast<const guint8*>(svg.data()), svg.size(), &error));
  const auto fail = [&](const char* stage) {
    std::string message = std::string("librsvg: ") + stage + (error ? std::string(": ") + error->message : "");
    if (error) g_error_free(error);
    throw NumericalError(message);
  };
  if (!handle) fail("cannot read the drawing");
  gdouble width = 0, height = 0;
  if (!rsvg_handle_get_intrinsic_size_in_pixels(handle.get(), &width, &height)) fail("no size");
  struct SurfaceFree {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  };
  struct ContextFree {
    void operator()(cairo_t* context) const { cairo_destroy(context); }
  };
  const int columns = static_cast<int>(std::ceil(width * scale)), rows = static_cast<int>(std::ceil(height * scale));
  const std::unique_ptr<cairo_surface_t, SurfaceFree> surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, columns, rows));
  const std::unique_ptr<cairo_t, ContextFree> context(cairo_create(surface.get()));
  const RsvgRectangle viewport{0, 0, static_cast<double>(columns), static_cast<double>(rows)};
  if (!rsvg_handle_render_document(handle.get(), context.get(), &viewport, &error)) fail("cannot draw");
  std::string bytes;
  const auto append = [](void* closure, const unsigned char* data, unsigned int length) {
    static_cast<std::string*>(closure)->append(reinterpret_cast<const char*>(data), length);
    return CAIRO_STATUS_SUCCESS;
  };
  if (cairo_surface_write_to_png_stream(surface.get(), append, &bytes) != CAIRO_STATUS_SUCCESS) fail("no PNG");
  return bytes;
}

std::string base64(std::string_view bytes) {
  std::string text((bytes.size() + 2) / 3 * 4 + 1, '\0');  // EVP_EncodeBlock ends it with a 0
  const int n = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(n));
  return text;
}

std::string data_uri(std::string_view media_type, std::string_view bytes) {
  return "data:" + std::string(media_type) + ";base64," + base64(bytes);
}

RgbaImage reduced(const RgbaImage& image, int factor) {
  KLANG_CHECK(factor >= 1, "a factor of at least one");
  RgbaImage result{image.width / factor, image.height / factor, {}};
  if (result.width < 1 || result.height < 1) return image;
  result.pixels.resize(static_cast<std::size_t>(result.width) * static_cast<std::size_t>(result.height) * 4);
  for (int row = 0; row < result.height; ++row) {
    for (int column = 0; column < result.width; ++column) {
      int sum[4] = {0, 0, 0, 0};
      for (int i = 0; i < factor; ++i) {
        for (int j = 0; j < factor; ++j) {
          const std::uint8_t* p =
              &image.pixels[(static_cast<std::size_t>(row * factor + i) * static_cast<std::size_t>(image.width) +
                             static_cast<std::size_t>(column * factor + j)) *
                            4];
          for (int c = 0; c < 3; ++c) sum[c] += p[c] * p[3];
          sum[3] += p[3];
        }
      }
      std::uint8_t* q = &result.pixels[(static_cast<std::size_t>(row) * static_cast<std::size_t>(result.width) +
                                        static_cast<std::size_t>(column)) *
                                       4];
      for (int c = 0; c < 3; ++c) q[c] = static_cast<std::uint8_t>(sum[3] > 0 ? (sum[c] + sum[3] / 2) / sum[3] : 0);
      q[3] = static_cast<std::uint8_t>((sum[3] + factor * factor / 2) / (factor * factor));
    }
  }
  return result;
}

RgbaImage trimmed(const RgbaImage& image, int margin) {
  int left = image.width, right = -1, top = image.height, bottom = -1;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      if (image.pixels[(static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                        static_cast<std::size_t>(column)) *
                           4 +
                       3] == 0)
        continue;
      left = std::min(left, column);
      right = std::max(right, column);
      top = std::min(top, row);
      bottom = std::max(bottom, row);
    }
  }
  if (right < 0) return image;
  left = std::max(left - margin, 0);
  top = std::max(top - margin, 0);
  right = std::min(right + margin, image.width - 1);
  bottom = std::min(bottom + margin, image.height - 1);
  RgbaImage result{right - left + 1, bottom - top + 1, {}};
  for (int row = top; row <= bottom; ++row) {
    const auto from = image.pixels.begin() + (static_cast<std::ptrdiff_t>(row) * image.width + left) * 4;
    result.pixels.insert(result.pixels.end(), from, from + static_cast<std::ptrdiff_t>(result.width) * 4);
  }
  return result;
}

}  // namespace klang::reports::detail
