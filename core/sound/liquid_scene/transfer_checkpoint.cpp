#include "core/sound/liquid_scene/transfer_checkpoint.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <type_traits>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/sealed_file.hpp"

namespace klang::liquid_scene {
namespace {

constexpr std::uint64_t kTransferMagic = 0x3352544e474e4c4bULL;  // "KLNGNTR3"

using Complex = std::complex<double>;

/// The same fields in the same order, written or read.
class Writer {
 public:
  static constexpr bool kReads = false;
  explicit Writer(std::ofstream& out) : out_(out) {}
  template <class T>
  void block(const T* data, std::uint64_t n) {
    static_assert(std::is_trivially_copyable_v<T> || std::is_same_v<T, std::complex<double>> ||
                  std::is_same_v<T, std::complex<float>>);
    out_.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(n * sizeof(T)));
  }
  template <class T>
  void one(T& value) {
    block(&value, 1);
  }
  template <class T>
  void list(std::vector<T>& values) {
    std::uint64_t n = values.size();
    one(n);
    block(values.data(), n);
  }

 private:
  std::ofstream& out_;
};

class Reader {
 public:
  static constexpr bool kReads = true;
  Reader(std::ifstream& in, std::string name) : in_(in), name_(std::move(name)) {}
  template <class T>
  void block(T* data, std::uint64_t n) {
    if (!in_.read(reinterpret_cast<char*>(data), static_cast<std::streamsize>(n * sizeof(T)))) fail();
  }
  template <class T>
  void one(T& value) {
    block(&value, 1);
  }
  template <class T>
  void list(std::vector<T>& values) {
    std::uint64_t n = 0;
    one(n);
    read_list(in_, values, n, name_);
  }
  /// Whether the rest of the file can hold n things of that size, before memory for them is asked for.
  void room_for(std::uint64_t n, std::uint64_t bytes_each) {
    if (n > bytes_left(in_) / bytes_each) fail();
  }
  [[noreturn]] void fail() const { throw InputError(name_, "is damaged", "", "a run without --resume"); }

 private:
  std::ifstream& in_;
  std::string name_;
};

template <class File>
void pass_text(File& file, std::string& text) {
  std::vector<char> letters(text.begin(), text.end());
  file.list(letters);
  text.assign(letters.begin(), letters.end());
}

template <class File>
void pass_found(File& file, LiquidTransfer& found) {
  std::uint64_t n_paths = found.rows.size();
  file.one(n_paths);
  if constexpr (File::kReads) {
    file.room_for(n_paths, sizeof(std::uint64_t));
    found.rows.resize(n_paths);
  }
  for (std::vector<bubble::TransferSeries::Row>& rows : found.rows) {
    std::vector<double> numbers;
    for (const auto& row : rows)
      numbers.insert(numbers.end(),
                     {row.time_s, row.frequency_hz, row.pressure_pa_per_m.real(), row.pressure_pa_per_m.imag()});
    file.list(numbers);
    rows.clear();
    for (std::size_t i = 0; i + 3 < numbers.size(); i += 4)
      rows.push_back({numbers[i], numbers[i + 1], {numbers[i + 2], numbers[i + 3]}});
  }
  file.one(found.n_solves);
  file.one(found.n_iterations);
  file.one(found.n_airs);
  file.one(found.n_not_converged);
  file.list(found.errors);
  std::uint64_t n_half_space = found.n_half_space, n_bad = found.n_bad_frames;
  file.one(n_half_space);
  file.one(n_bad);
  found.n_half_space = n_half_space;
  found.n_bad_frames = n_bad;
  pass_text(file, found.bad_frame);
  file.list(found.modes_hz);
}

template <class File>
void pass_field(File& file, Eigen::MatrixXcd& q) {
  std::int64_t rows = q.rows(), columns = q.cols();
  file.one(rows);
  file.one(columns);
  if constexpr (File::kReads) {
    if (rows < 0 || columns < 0 || columns > 1000) file.fail();
    file.room_for(static_cast<std::uint64_t>(rows), sizeof(Complex) * std::max<std::uint64_t>(columns, 1));
    q.resize(rows, columns);
  }
  file.block(q.data(), static_cast<std::uint64_t>(rows * columns));
}

template <class File>
void pass_waves(File& file, CellEarState& cells) {
  file.one(cells.n_cells);
  file.list(cells.wet);
  std::uint64_t n_waves = cells.waves.size();
  file.one(n_waves);
  const auto pass = [&](std::uint64_t bubble, CellEarState::Wave& wave) {
    file.one(bubble);
    file.one(wave.frequency_hz);
    file.list(wave.w);
    return bubble;
  };
  if constexpr (File::kReads) {
    for (std::uint64_t i = 0; i < n_waves; ++i) {
      CellEarState::Wave wave;
      const std::uint64_t bubble = pass(0, wave);
      cells.waves[bubble] = std::move(wave);
    }
  } else {
    for (auto& [bubble, wave] : cells.waves) pass(bubble, wave);
  }
}

template <class File>
void pass_cells(File& file, CellEarState& cells) {
  file.one(cells.made_s);
  file.one(cells.life_s);
  file.one(cells.change);
  file.one(cells.changed_hz);
  std::uint64_t n_bins = cells.q.size();
  file.one(n_bins);
  if constexpr (File::kReads) {
    for (std::uint64_t i = 0; i < n_bins; ++i) {
      std::int32_t bin = 0;
      file.one(bin);
      pass_field(file, cells.q[bin]);
    }
  } else {
    for (auto& [number, q] : cells.q) {
      std::int32_t bin = number;
      file.one(bin);
      pass_field(file, q);
    }
  }
  pass_waves(file, cells);
}

template <class File>
void pass_checkpoint(File& file, TransferCheckpoint& c) {
  file.one(c.next_frame);
  file.one(c.wall_s);
  file.one(c.cpu_s);
  pass_found(file, c.found);
  std::uint8_t by_cells = c.by_cells ? 1 : 0;
  file.one(by_cells);
  c.by_cells = by_cells != 0;
  std::uint64_t air = c.air_frame ? *c.air_frame + 1 : 0;
  file.one(air);
  c.air_frame = air == 0 ? std::nullopt : std::optional<std::uint64_t>(air - 1);
  pass_cells(file, c.cells);
}

}  // namespace

std::optional<double> LiquidTransfer::error_estimate() const {
  if (errors.empty()) return std::nullopt;
  std::vector<double> all;
  for (const TransferError& error : errors) all.push_back(error.relative);
  std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2), all.end());
  return all[all.size() / 2];
}

std::optional<std::array<double, 2>> LiquidTransfer::error_interval() const {
  constexpr double kBeyond = 0.05;     // at each end
  constexpr std::size_t kMost = 1000;  // of more, the first ones: 2^-n stays a number
  const std::size_t n = std::min(errors.size(), kMost);
  std::vector<double> all;
  for (std::size_t e = 0; e < n; ++e) all.push_back(errors[e].relative);
  std::sort(all.begin(), all.end());
  // P(the median is below the entry of rank k) = P(at most k of n fair coins are heads)
  double term = std::exp2(-static_cast<double>(n)), below = term;
  if (below > kBeyond) return std::nullopt;
  std::size_t rank = 0;
  while (rank < n / 2) {
    term *= static_cast<double>(n - rank) / static_cast<double>(rank + 1);
    if (below + term > kBeyond) break;
    below += term;
    ++rank;
  }
  return std::array{all[rank], all[n - 1 - rank]};
}

void write_transfer_checkpoint(const std::filesystem::path& path, const std::string& key,
                               TransferCheckpoint checkpoint) {
  write_file_with(path, [&](const std::filesystem::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    Writer file(out);
    std::uint64_t magic = kTransferMagic;
    file.one(magic);
    std::string name = key;
    pass_text(file, name);
    pass_checkpoint(file, checkpoint);
    if (!out.flush()) throw InputError(path.string(), "cannot be written", "", "room on the disk");
    out.close();
    seal_file(temporary);
  });
}

std::optional<TransferCheckpoint> read_transfer_checkpoint(const std::filesystem::path& path, const std::string& key) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return std::nullopt;
  Reader file(in, path.string());
  std::uint64_t magic = 0;
  file.one(magic);
  if (magic != kTransferMagic) return std::nullopt;
  if (!is_sealed(path)) file.fail();
  std::string name;
  pass_text(file, name);
  if (name != key) return std::nullopt;
  TransferCheckpoint checkpoint;
  pass_checkpoint(file, checkpoint);
  return checkpoint;
}

}  // namespace klang::liquid_scene
