#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace klang::scene {

/// The surface of a cracking or modal body between two changes of its mesh.
struct DeformedSurface {
  std::vector<std::array<std::int32_t, 3>> triangles;
  /// Of each triangle: row of the log's bodies that has it once the body has broken (the body's own where it never does).
  std::vector<std::int32_t> rows;
};

/// What it looked like at the time number / rate_hz.
struct DeformedFrame {
  std::int32_t number = 0;      ///< of the frame
  std::int32_t surface = 0;     ///< of the body's
  std::vector<float> places_m;  ///< x, y, z of each corner, in the world
};

struct DeformedBody {
  std::int32_t row = 0;     ///< of the log's bodies
  std::int32_t stride = 1;  ///< of so many frames one is kept
  std::vector<DeformedSurface> surfaces;
  std::vector<DeformedFrame> frames;  ///< rising numbers from 0 on, each a multiple of stride
};

/// The shapes of a scene's bodies that deform at the times of its frames.
struct DeformedShapes {
  std::vector<DeformedBody> bodies;
};

/// shapes.bin of a run's folder: what its frames are made of, sealed.
void write_shapes(const std::filesystem::path& path, const DeformedShapes& shapes);
/// @param n_rows  of the log's bodies. @throws InputError: damaged, or of another run
DeformedShapes read_shapes(const std::filesystem::path& path, int n_rows);

}  // namespace klang::scene
