#include "core/geometry/files/vtk_xml.hpp"

#include <algorithm>
#include <array>
#include <pugixml.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/files/byte_cursor.hpp"
#include "core/geometry/files/detail/vtk_data.hpp"

namespace klang::mesh {
namespace {

constexpr std::ptrdiff_t kMostElements = 200'000;  // of the XML: an array each, and a few around them
constexpr std::int64_t kMostItems = 2147483647;    // points, cells and corners are counted by int
constexpr std::int64_t kSmallMemory = std::int64_t{256} << 20;
constexpr std::int64_t kMemoryPerByte = 100;

std::int64_t file_budget(std::size_t n_bytes) {
  return std::max(kSmallMemory, kMemoryPerByte * static_cast<std::int64_t>(n_bytes));
}

std::string shown(std::string_view text) {
  std::string result;
  for (const char c : text.substr(0, 32)) result += c >= ' ' && c <= '~' ? c : '?';
  return result;
}

const char* element_of(VtkPlace place) {
  return place == VtkPlace::kPointData ? "PointData" : place == VtkPlace::kCellData ? "CellData" : "FieldData";
}

}  // namespace

struct VtkXmlFile::Impl {
  std::string bytes, name, text;  // text: what the parser works in
  pugi::xml_document document;
  pugi::xml_node data_set;
  std::vector<pugi::xml_node> pieces;
  std::vector<std::int64_t> points_of, cells_of;  // per piece
  detail::VtkEncoding encoding;
  std::string_view appended;  // from behind the "_"
  bool appended_base64 = false;
  bool polygons = false;
  mutable std::int64_t budget = 0;

  [[noreturn]] void fail(const std::string& problem, std::string_view value = {}, std::string_view allowed = {}) const {
    throw InputError(name, problem, shown(value), allowed);
  }

  void parse(std::string_view type);
  void read_header(const pugi::xml_node& root);
  void find_pieces();
  pugi::xml_node only_child(const pugi::xml_node& parent, const char* element) const;
  std::int64_t count(const pugi::xml_node& element, const char* attribute, std::int64_t fallback) const;
  std::string place_of(const pugi::xml_node& array) const {
    return name + ": array " + shown(array.attribute("Name").value());
  }
  std::string block_of(const pugi::xml_node& array, std::int64_t n_bytes, std::int64_t memory_per_byte) const;
  VtkArray values(const pugi::xml_node& array, std::int64_t n_tuples) const;
  std::vector<std::int64_t> integers(const pugi::xml_node& parent, const char* array, std::int64_t n) const;
  pugi::xml_node find_array(const pugi::xml_node& parent, std::string_view array) const;
  void add_cells(const pugi::xml_node& element, std::int64_t n, std::size_t piece, std::int64_t first_point,
                 VtkCells& cells) const;
};

/// The XML ends before raw data, which no parser takes.
void VtkXmlFile::Impl::parse(std::string_view type) {
  if (std::string_view(bytes).substr(0, 4096).find("<VTKFile") == std::string_view::npos)
    fail("not a VTK XML file", "", "<VTKFile");
  if (bytes.find("</VTKFile>") == std::string::npos) fail("the file is truncated", "", "</VTKFile> at its end");
  const std::size_t tag = bytes.find("<AppendedData");
  if (tag == std::string::npos) {
    text = bytes;
  } else {
    const std::size_t end = bytes.find('>', tag);
    std::size_t begin = end == std::string::npos ? end : bytes.find_first_not_of(" \t\r\n", end + 1);
    if (begin == std::string::npos || bytes[begin] != '_') fail("AppendedData does not start with _");
    appended = std::string_view(bytes).substr(begin + 1);
    text = bytes.substr(0, end + 1) + "</AppendedData></VTKFile>";
  }
  if (std::count(text.begin(), text.end(), '<') > 2 * kMostElements)
    fail("it has too many XML elements", "", std::to_string(kMostElements));
  const pugi::xml_parse_result result = document.load_buffer_inplace(text.data(), text.size(), pugi::parse_default);
  if (!result) {
    const auto at = std::min(static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0)), bytes.size());
    const auto line = 1 + std::count(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    throw InputError(name + ": line " + std::to_string(line), "is no XML", result.description());
  }
  const pugi::xml_node root = document.child("VTKFile");
  if (root.attribute("type").value() != type)
    fail("its VTKFile is of another type", root.attribute("type").value(), type);
  read_header(root);
  data_set = only_child(root, std::string(type).c_str());
  if (!data_set) fail("its element " + std::string(type) + " is missing");
  polygons = type == "PolyData";
  find_pieces();
}

void VtkXmlFile::Impl::read_header(const pugi::xml_node& root) {
  const std::string_view order = root.attribute("byte_order").as_string("LittleEndian");
  if (order != "LittleEndian" && order != "BigEndian") fail("byte_order", order, "LittleEndian, BigEndian");
  encoding.swapped = order == "BigEndian";
  const std::string_view header = root.attribute("header_type").as_string("UInt32");
  if (header != "UInt32" && header != "UInt64") fail("header_type", header, "UInt32, UInt64");
  encoding.header_bytes = header == "UInt64" ? 8 : 4;
  const std::string_view compressor = root.attribute("compressor").as_string("");
  encoding.compressor = compressor == "vtkZLibDataCompressor"   ? detail::VtkCompressor::kZlib
                        : compressor == "vtkLZ4DataCompressor"  ? detail::VtkCompressor::kLz4
                        : compressor == "vtkLZMADataCompressor" ? detail::VtkCompressor::kLzma
                                                                : detail::VtkCompressor::kNone;
  if (!compressor.empty() && encoding.compressor == detail::VtkCompressor::kNone)
    fail("compressor", compressor, "vtkZLibDataCompressor, vtkLZ4DataCompressor, vtkLZMADataCompressor");
  const std::string_view appended_encoding = root.child("AppendedData").attribute("encoding").as_string("base64");
  if (appended_encoding != "base64" && appended_encoding != "raw")
    fail("encoding of AppendedData", appended_encoding, "raw, base64");
  appended_base64 = appended_encoding == "base64";
  budget = file_budget(bytes.size());
}

void VtkXmlFile::Impl::find_pieces() {
  std::int64_t n_points = 0, n_cells = 0;
  for (const pugi::xml_node& piece : data_set.children("Piece")) {
    pieces.push_back(piece);
    points_of.push_back(count(piece, "NumberOfPoints", -1));
    cells_of.push_back(0);
    if (!polygons) {
      cells_of.back() = count(piece, "NumberOfCells", -1);
    } else {
      for (const char* kind : {"NumberOfVerts", "NumberOfLines", "NumberOfPolys", "NumberOfStrips"})
        cells_of.back() += count(piece, kind, 0);
    }
    n_points += points_of.back();
    n_cells += cells_of.back();
    if (n_points > kMostItems || n_cells > kMostItems) fail("it has too many points or cells");
  }
  if (pieces.empty()) fail("it has no Piece");
}

pugi::xml_node VtkXmlFile::Impl::only_child(const pugi::xml_node& parent, const char* element) const {
  const pugi::xml_node found = parent.child(element);
  if (found && found.next_sibling(element)) fail(std::string(element) + " is there twice");
  return found;
}

/// @param fallback of a missing attribute; negative: it must be there. No array of this file could hold more than the budget allows.
std::int64_t VtkXmlFile::Impl::count(const pugi::xml_node& element, const char* attribute,
                                     std::int64_t fallback) const {
  const pugi::xml_attribute found = element.attribute(attribute);
  if (!found && fallback >= 0) return fallback;
  long long n = 0;
  if (!found || !parse_integer(found.value(), n) || n < 0)
    fail(std::string(attribute) + " is no count", found.value(), "0 or more");
  if (n > kMostItems || n > file_budget(bytes.size()) / 8)
    fail(std::string(attribute) + " does not fit the length of the file", found.value());
  return n;
}

std::string VtkXmlFile::Impl::block_of(const pugi::xml_node& array, std::int64_t n_bytes,
                                       std::int64_t memory_per_byte) const {
  const std::string place = place_of(array);
  const std::string_view format = array.attribute("format").as_string("ascii");
  if (format == "appended") {
    long long offset = 0;
    if (!parse_integer(array.attribute("offset").value(), offset) || offset < 0 ||
        static_cast<std::uint64_t>(offset) >= appended.size())
      throw InputError(place, "its offset lies outside the file", shown(array.attribute("offset").value()));
    return detail::vtk_block(
        {appended.substr(static_cast<std::size_t>(offset)), appended_base64, n_bytes, memory_per_byte}, encoding,
        budget, place);
  }
  if (format != "binary") throw InputError(place, "format", shown(format), "ascii, binary, appended");
  std::string data;  // beside its text an array may have elements of its own: information keys
  for (const pugi::xml_node& child : array.children()) data += child.type() == pugi::node_pcdata ? child.value() : "";
  return detail::vtk_block({data, true, n_bytes, memory_per_byte}, encoding, budget, place);
}

/// @param n_tuples -1: as many as there are
VtkArray VtkXmlFile::Impl::values(const pugi::xml_node& array, std::int64_t n_tuples) const {
  const std::string place = place_of(array);
  VtkArray result;
  result.type = array.attribute("type").value();
  const int each = detail::vtk_type_bytes(result.type);
  if (each == 0) throw InputError(place, "its type is unknown", shown(result.type), "Int8 to UInt64, Float32, Float64");
  result.n_components = count(array, "NumberOfComponents", 1);
  if (result.n_components < 1 || result.n_components > 1000)
    throw InputError(place, "NumberOfComponents", std::to_string(result.n_components), "1 to 1000");
  const std::int64_t wanted = n_tuples < 0 ? -1 : n_tuples * result.n_components;
  if (std::string_view(array.attribute("format").as_string("ascii")) == "ascii") {
    for (const pugi::xml_node& child : array.children())
      if (child.type() == pugi::node_pcdata)
        detail::vtk_ascii(child.value(), result.type, wanted, place, result.reals, result.integers);
    if (wanted >= 0 && static_cast<std::int64_t>(result.size()) != wanted)
      throw InputError(place, "has a wrong number of values", std::to_string(result.size()), std::to_string(wanted));
  } else {
    const std::string block = block_of(array, wanted < 0 ? -1 : wanted * each, 8 / each);
    if (block.size() % static_cast<std::size_t>(each) != 0)
      throw InputError(place, "its length is no multiple of its type's", std::to_string(block.size()));
    detail::vtk_values(block, result.type, encoding.swapped, result.reals, result.integers);
  }
  if (result.size() % static_cast<std::size_t>(result.n_components) != 0)
    throw InputError(place, "its length is no multiple of its components", std::to_string(result.size()));
  return result;
}

pugi::xml_node VtkXmlFile::Impl::find_array(const pugi::xml_node& parent, std::string_view array) const {
  pugi::xml_node found;
  for (const pugi::xml_node& child : parent.children()) {
    if (child.attribute("Name").value() != array) continue;
    if (found) fail("array " + shown(array) + " is there twice");
    found = child;
  }
  return found;
}

/// Of an element with cells; n: -1 any number.
std::vector<std::int64_t> VtkXmlFile::Impl::integers(const pugi::xml_node& parent, const char* array,
                                                     std::int64_t n) const {
  const pugi::xml_node found = find_array(parent, array);
  if (!found) fail(std::string("array ") + array + " is missing");
  VtkArray values_of = values(found, n);
  if (detail::vtk_type_is_real(values_of.type)) throw InputError(place_of(found), "is no array of integers");
  return std::move(values_of.integers);
}

void VtkXmlFile::Impl::add_cells(const pugi::xml_node& element, std::int64_t n, std::size_t piece,
                                 std::int64_t first_point, VtkCells& cells) const {
  if (n == 0) return;
  if (!element) fail("its cells are missing");
  const std::vector<std::int64_t> offsets = integers(element, "offsets", n);
  const std::vector<std::int64_t> corners = integers(element, "connectivity", -1);
  const auto first_corner = static_cast<std::int64_t>(cells.connectivity.size());
  std::int64_t last = 0;
  for (const std::int64_t offset : offsets) {
    if (offset < last || offset > static_cast<std::int64_t>(corners.size()))
      fail("offsets of cells do not fit their corners", std::to_string(offset),
           std::to_string(last) + " to " + std::to_string(corners.size()));
    last = offset;
    cells.offsets.push_back(first_corner + offset);
  }
  if (last != static_cast<std::int64_t>(corners.size()))
    fail("connectivity is longer than the offsets say", std::to_string(corners.size()), std::to_string(last));
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (corners[i] < 0 || corners[i] >= points_of[piece]) {
      const auto cell = std::upper_bound(offsets.begin(), offsets.end(), static_cast<std::int64_t>(i));
      const auto number = static_cast<std::int64_t>(cells.offsets.size()) - n + (cell - offsets.begin());
      fail("element " + std::to_string(number) + ": node out of range", std::to_string(corners[i]),
           "0 to " + std::to_string(points_of[piece] - 1));
    }
    cells.connectivity.push_back(first_point + corners[i]);
  }
}

VtkXmlFile::VtkXmlFile(std::string bytes, std::string name, std::string_view type) : impl_(std::make_unique<Impl>()) {
  impl_->bytes = std::move(bytes);
  impl_->name = std::move(name);
  impl_->parse(type);
}
VtkXmlFile::~VtkXmlFile() = default;
VtkXmlFile::VtkXmlFile(VtkXmlFile&&) noexcept = default;
VtkXmlFile& VtkXmlFile::operator=(VtkXmlFile&&) noexcept = default;

const std::string& VtkXmlFile::name() const { return impl_->name; }

std::int64_t VtkXmlFile::n_points() const {
  std::int64_t n = 0;
  for (const std::int64_t of_piece : impl_->points_of) n += of_piece;
  return n;
}

std::int64_t VtkXmlFile::n_cells() const {
  std::int64_t n = 0;
  for (const std::int64_t of_piece : impl_->cells_of) n += of_piece;
  return n;
}

Points VtkXmlFile::points() const {
  std::vector<double> all;
  for (std::size_t p = 0; p < impl_->pieces.size(); ++p) {
    if (impl_->points_of[p] == 0) continue;
    const pugi::xml_node array = impl_->only_child(impl_->only_child(impl_->pieces[p], "Points"), "DataArray");
    if (!array) impl_->fail("piece " + std::to_string(p) + " has no Points");
    const VtkArray values = impl_->values(array, impl_->points_of[p]);
    if (values.n_components != 3)
      impl_->fail("its points have a wrong number of components", std::to_string(values.n_components), "3");
    for (std::size_t i = 0; i < values.size(); ++i) all.push_back(values.number(i));
  }
  return Eigen::Map<const Points>(all.data(), static_cast<Eigen::Index>(all.size() / 3), 3);
}

VtkCells VtkXmlFile::cells() const {
  VtkCells cells;
  std::int64_t first_point = 0;
  for (std::size_t p = 0; p < impl_->pieces.size(); ++p) {
    const pugi::xml_node& piece = impl_->pieces[p];
    if (!impl_->polygons) {
      const pugi::xml_node element = impl_->only_child(piece, "Cells");
      impl_->add_cells(element, impl_->cells_of[p], p, first_point, cells);
      if (impl_->cells_of[p] > 0)
        for (const std::int64_t type : impl_->integers(element, "types", impl_->cells_of[p]))
          cells.types.push_back(static_cast<int>(std::clamp<std::int64_t>(type, -1, 1000)));
    }
    // The order of VTK's own cells; types: of one corner or line, of several.
    constexpr std::array<const char*, 4> kKinds{"Verts", "Lines", "Polys", "Strips"};
    for (std::size_t k = 0; impl_->polygons && k < kKinds.size(); ++k) {
      const std::int64_t n = impl_->count(piece, (std::string("NumberOf") + kKinds[k]).c_str(), 0);
      impl_->add_cells(impl_->only_child(piece, kKinds[k]), n, p, first_point, cells);
      for (std::size_t c = cells.types.size(); c < cells.offsets.size(); ++c) {
        const std::int64_t corners = cells.offsets[c] - cells.begin(c);
        cells.types.push_back(k == 0   ? (corners == 1 ? 1 : 2)
                              : k == 1 ? (corners == 2 ? 3 : 4)
                              : k == 2 ? (corners == 3   ? 5
                                          : corners == 4 ? 9
                                                         : 7)
                                       : 6);
      }
    }
    first_point += impl_->points_of[p];
  }
  return cells;
}

std::vector<std::string> VtkXmlFile::array_names(VtkPlace place) const {
  std::vector<std::string> names;
  const pugi::xml_node parent =
      impl_->only_child(place == VtkPlace::kFieldData ? impl_->data_set : impl_->pieces.front(), element_of(place));
  for (const pugi::xml_node& array : parent.children())
    if (array.attribute("Name")) names.emplace_back(array.attribute("Name").value());
  return names;
}

std::optional<VtkArray> VtkXmlFile::find(VtkPlace place, std::string_view array) const {
  if (place == VtkPlace::kFieldData) {
    const pugi::xml_node found = impl_->find_array(impl_->only_child(impl_->data_set, element_of(place)), array);
    if (!found || std::string_view(found.name()) != "DataArray") return std::nullopt;
    return impl_->values(found, found.attribute("NumberOfTuples") ? impl_->count(found, "NumberOfTuples", -1) : -1);
  }
  std::optional<VtkArray> all;
  for (std::size_t p = 0; p < impl_->pieces.size(); ++p) {
    const pugi::xml_node found = impl_->find_array(impl_->only_child(impl_->pieces[p], element_of(place)), array);
    if (!found) return std::nullopt;
    VtkArray part = impl_->values(found, place == VtkPlace::kPointData ? impl_->points_of[p] : impl_->cells_of[p]);
    if (!all) {
      all = std::move(part);
      continue;
    }
    if (part.type != all->type || part.n_components != all->n_components)
      impl_->fail("array " + shown(array) + " is of another kind in piece " + std::to_string(p));
    all->reals.insert(all->reals.end(), part.reals.begin(), part.reals.end());
    all->integers.insert(all->integers.end(), part.integers.begin(), part.integers.end());
  }
  return all;
}

std::optional<std::string> VtkXmlFile::find_text(std::string_view array) const {
  const pugi::xml_node found =
      impl_->find_array(impl_->only_child(impl_->data_set, element_of(VtkPlace::kFieldData)), array);
  if (!found || std::string_view(found.attribute("type").value()) != "String") return std::nullopt;
  std::string text;
  if (std::string_view(found.attribute("format").as_string("ascii")) == "ascii") {
    std::vector<double> unused;
    std::vector<std::int64_t> codes;
    for (const pugi::xml_node& child : found.children())
      if (child.type() == pugi::node_pcdata)
        detail::vtk_ascii(child.value(), "Int8", -1, impl_->place_of(found), unused, codes);
    for (const std::int64_t code : codes) text += static_cast<char>(code);
  } else {
    text = impl_->block_of(found, -1, 1);
  }
  if (text.find('\0') == std::string::npos) throw InputError(impl_->place_of(found), "its text does not end");
  return text.substr(0, text.find('\0'));
}

}  // namespace klang::mesh
