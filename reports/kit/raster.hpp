#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// Pixels to PNG, drawings to pixels, bytes to data URIs.
namespace klang::reports::detail {

/// Each pixel an index into 256 colours (row by row from the upper left).
struct IndexedImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

/// Red, green, blue, alpha (not premultiplied), row by row from the upper left.
struct RgbaImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

/// 256 colours of even perceptual steps from near black over violet and orange to pale yellow.
const std::array<std::array<std::uint8_t, 3>, 256>& heat_palette();

std::string png_bytes(const IndexedImage& image, const std::array<std::array<std::uint8_t, 3>, 256>& palette);
std::string png_bytes(const RgbaImage& image);

/// The drawing as a PNG, scale pixels to a CSS pixel. @throws NumericalError when librsvg cannot draw it.
std::string png_of_svg(std::string_view svg, double scale);

std::string base64(std::string_view bytes);
/// "data:image/png;base64,..."
std::string data_uri(std::string_view media_type, std::string_view bytes);

/// Averages blocks of factor x factor pixels (colour weighted by alpha).
RgbaImage reduced(const RgbaImage& image, int factor);
/// Without the empty border, but for `margin` pixels; the image itself where all of it is empty.
RgbaImage trimmed(const RgbaImage& image, int margin);

}  // namespace klang::reports::detail
