#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// The numbers of a VTK XML file's arrays.
namespace klang::mesh::detail {

enum class VtkCompressor { kNone, kZlib, kLz4, kLzma };

/// What the file's first element says of all its arrays.
struct VtkEncoding {
  bool swapped = false;  ///< big-endian
  int header_bytes = 4;  ///< of each count before data: 4 or 8
  VtkCompressor compressor = VtkCompressor::kNone;
};

/// Bytes of one type's value, 0 for an unknown one.
int vtk_type_bytes(std::string_view type);
inline bool vtk_type_is_real(std::string_view type) { return type == "Float32" || type == "Float64"; }

/// A block to be unpacked.
struct VtkBlock {
  std::string_view at;  ///< raw bytes or base64 text, from the block's header to the end of what is there
  bool base64 = false;
  std::int64_t n_bytes_wanted = -1;  ///< what it must hold; -1: any
  std::int64_t memory_per_byte = 1;  ///< that its numbers take
};

/// The block of an array, unpacked, in the file's byte order. What its numbers take in memory is held against the budget and
/// taken off. @param place for complaints (InputError)
std::string vtk_block(const VtkBlock& block, const VtkEncoding& encoding, std::int64_t& budget,
                      const std::string& place);

/// Values of ASCII data; nothing else may stand there. At most n_wanted + 1 are read where n_wanted is not negative.
void vtk_ascii(std::string_view text, std::string_view type, std::int64_t n_wanted, const std::string& place,
               std::vector<double>& reals, std::vector<std::int64_t>& integers);

/// Values of a block.
void vtk_values(std::string_view block, std::string_view type, bool swapped, std::vector<double>& reals,
                std::vector<std::int64_t>& integers);

}  // namespace klang::mesh::detail
