#include "core/sound/scene/deformed_shapes.hpp"

#include <algorithm>
#include <fstream>
#include <string>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/sealed_file.hpp"

namespace klang::scene {
namespace {

constexpr std::uint64_t kMagic = 0x3250414853474e4cULL;  // "LNGSHAP2"

/// Reads what was written, and fails with the name of the file.
class Shelf {
 public:
  explicit Shelf(const std::filesystem::path& path) : name_(path.string()), in_(path, std::ios::binary) {}
  [[noreturn]] void fail() const { throw InputError(name_, "is damaged or cut off"); }
  void require(bool holds) const {
    if (!holds) fail();
  }
  template <class T>
  T take() {
    return read_value<T>(in_, name_);
  }
  /// Of what follows, each thing of so many bytes at least.
  std::uint64_t count(std::uint64_t least_bytes) {
    const auto n = take<std::uint64_t>();
    require(n <= bytes_left(in_) / least_bytes);
    return n;
  }
  template <class T>
  void take_list(std::vector<T>& values) {
    const auto n = take<std::uint64_t>();
    read_list(in_, values, n, name_);
  }

 private:
  std::string name_;
  std::ifstream in_;
};

void require_whole(const DeformedBody& body, int n_rows, const Shelf& shelf) {
  std::vector<std::int32_t> highest;
  for (const DeformedSurface& surface : body.surfaces) {
    shelf.require(surface.triangles.size() == surface.rows.size());
    std::int32_t corner = -1;
    for (const auto& triangle : surface.triangles)
      for (const std::int32_t k : triangle) {
        shelf.require(k >= 0);
        corner = std::max(corner, k);
      }
    for (const std::int32_t row : surface.rows) shelf.require(row >= 0 && row < n_rows);
    highest.push_back(corner);
  }
  shelf.require(body.stride >= 1);
  std::int32_t before = -1;
  for (const DeformedFrame& frame : body.frames) {
    shelf.require(frame.surface >= 0 && static_cast<std::size_t>(frame.surface) < highest.size());
    shelf.require(frame.places_m.size() % 3 == 0 &&
                  frame.places_m.size() / 3 >
                      static_cast<std::size_t>(highest[static_cast<std::size_t>(frame.surface)]));
    shelf.require(frame.number % body.stride == 0 && frame.number > before);
    before = frame.number;
  }
  shelf.require(!body.frames.empty() && body.frames.front().number == 0 && body.row >= 0 && body.row < n_rows);
}

}  // namespace

void write_shapes(const std::filesystem::path& path, const DeformedShapes& shapes) {
  write_file_with(path, [&](const std::filesystem::path& temporary) {
    {
      std::ofstream out(temporary, std::ios::binary);
      write_value(out, kMagic);
      write_value(out, static_cast<std::uint64_t>(shapes.bodies.size()));
      for (const DeformedBody& body : shapes.bodies) {
        write_value(out, body.row);
        write_value(out, body.stride);
        write_value(out, static_cast<std::uint64_t>(body.surfaces.size()));
        for (const DeformedSurface& surface : body.surfaces) {
          write_list(out, surface.triangles);
          write_list(out, surface.rows);
        }
        write_value(out, static_cast<std::uint64_t>(body.frames.size()));
        for (const DeformedFrame& frame : body.frames) {
          write_value(out, frame.number);
          write_value(out, frame.surface);
          write_list(out, frame.places_m);
        }
      }
      if (!out.flush()) throw InputError(path.string(), "cannot be written", "", "room on the disk");
    }
    seal_file(temporary);
  });
}

DeformedShapes read_shapes(const std::filesystem::path& path, int n_rows) {
  Shelf shelf(path);
  if (!is_sealed(path)) shelf.fail();
  shelf.require(shelf.take<std::uint64_t>() == kMagic);
  DeformedShapes shapes;
  shapes.bodies.resize(shelf.count(20));
  for (DeformedBody& body : shapes.bodies) {
    body.row = shelf.take<std::int32_t>();
    body.stride = shelf.take<std::int32_t>();
    body.surfaces.resize(shelf.count(16));
    for (DeformedSurface& surface : body.surfaces) {
      shelf.take_list(surface.triangles);
      shelf.take_list(surface.rows);
    }
    body.frames.resize(shelf.count(16));
    for (DeformedFrame& frame : body.frames) {
      frame.number = shelf.take<std::int32_t>();
      frame.surface = shelf.take<std::int32_t>();
      shelf.take_list(frame.places_m);
    }
    require_whole(body, n_rows, shelf);
  }
  return shapes;
}

}  // namespace klang::scene
