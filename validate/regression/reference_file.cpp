#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "validate/regression/reference_spectrum.hpp"

namespace klang::validate {
namespace {

using nlohmann::json;

double rounded_db(float power) {
  return std::round(100.0 * std::log10(std::max(static_cast<double>(power), 1e-20))) / 10.0;
}
float power_of(double level_db) { return static_cast<float>(std::pow(10.0, 0.1 * level_db)); }

/// The values under a path of the file; every complaint says where.
class Reader {
 public:
  Reader(const json& value, std::string place) : value_(value), place_(std::move(place)) {}

  double number(const char* key, double low, double high) const {
    const json& entry = at(key);
    if (!entry.is_number()) throw InputError(place_ + "." + key, "is not a number", entry.type_name());
    return checked(place_, key, entry.get<double>(), low, high);
  }
  std::optional<double> optional_number(const char* key, double low, double high) const {
    if (!value_.contains(key) || value_.at(key).is_null()) return {};
    return number(key, low, high);
  }
  int integer(const char* key, int low, int high) const {
    const json& entry = at(key);
    if (!entry.is_number_integer()) throw InputError(place_ + "." + key, "is not a whole number", entry.type_name());
    return static_cast<int>(checked(place_, key, entry.get<double>(), low, high));
  }
  std::string text(const char* key) const {
    const json& entry = at(key);
    if (!entry.is_string()) throw InputError(place_ + "." + key, "is not a text", entry.type_name());
    return entry.get<std::string>();
  }
  const json& list(const char* key) const {
    const json& entry = at(key);
    if (!entry.is_array()) throw InputError(place_ + "." + key, "is not a list", entry.type_name());
    return entry;
  }
  std::vector<double> numbers(const char* key, double low, double high) const {
    return numbers(list(key), key, low, high);
  }
  std::vector<double> numbers(const json& entries, const std::string& key, double low, double high) const {
    if (!entries.is_array()) throw InputError(place_ + "." + key, "is not a list", entries.type_name());
    std::vector<double> result;
    for (const json& entry : entries) {
      if (!entry.is_number()) throw InputError(place_ + "." + key, "holds what is not a number", entry.type_name());
      result.push_back(checked(place_, key, entry.get<double>(), low, high));
    }
    return result;
  }
  Reader child(const char* key) const {
    if (!at(key).is_object()) throw InputError(place_ + "." + key, "is not an object", at(key).type_name());
    return {at(key), place_ + "." + key};
  }

 private:
  const json& at(const char* key) const {
    const auto found = value_.find(key);
    if (found == value_.end()) throw InputError(place_, std::string("has no key ") + key);
    return *found;
  }
  const json& value_;
  std::string place_;
};

ReferencePartial read_partial(const json& entry, const std::string& place) {
  if (!entry.is_object()) throw InputError(place, "is not an object");
  const Reader row(entry, place);
  ReferencePartial p;
  p.partial.frequency_hz = row.number("frequency_hz", 1e-3, 1e7);
  p.partial.frequency_std_hz = row.number("frequency_std_hz", 0.0, 1e7);
  p.partial.decay_per_s = row.optional_number("decay_per_s", 1e-9, 1e9);
  p.partial.decay_std_per_s = row.optional_number("decay_std_per_s", 0.0, 1e9);
  p.partial.amplitude = row.number("amplitude", 0.0, 1e12);
  p.partial.amplitude_std = row.optional_number("amplitude_std", 0.0, 1e12);
  p.frequency_scatter_cents = row.number("frequency_scatter_cents", 0.0, 1e4);
  p.decay_scatter = row.number("decay_scatter", 0.0, 1e3);
  p.n_takes = row.integer("n_takes", 1, 1'000'000);
  return p;
}

Fingerprint read_fingerprint(const Reader& node) {
  Fingerprint f;
  f.window_s = node.number("window_s", 0.001, 1.0);
  f.hop_s = node.number("hop_s", 0.0005, 1.0);
  f.first_third = node.integer("first_third_octave", -30, 30);
  const std::vector<double> noise = node.numbers("noise_db", -300.0, 300.0);
  const json& rows = node.list("levels_db");
  if (rows.empty() || rows.size() % 4 != 0 || rows.size() != noise.size()) {
    throw InputError("fingerprint", "has the wrong number of bands", std::to_string(rows.size()),
                     "a multiple of 4, as in noise_db");
  }
  f.noise.resize(static_cast<Eigen::Index>(noise.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<double> row = node.numbers(rows[i], "levels_db", -300.0, 300.0);
    if (i == 0) f.power.resize(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(row.size()));
    if (row.empty() || static_cast<Eigen::Index>(row.size()) != f.power.cols()) {
      throw InputError("fingerprint.levels_db", "has rows of different lengths", std::to_string(row.size()));
    }
    const auto band = static_cast<Eigen::Index>(i);
    for (std::size_t t = 0; t < row.size(); ++t) f.power(band, static_cast<Eigen::Index>(t)) = power_of(row[t]);
    f.noise[band] = power_of(noise[i]);
  }
  return f;
}

}  // namespace

json to_json(const ReferenceSpectrum& reference) {
  json partials = json::array();
  for (const ReferencePartial& p : reference.partials) {
    partials.push_back({{"frequency_hz", json_number(p.partial.frequency_hz)},
                        {"frequency_std_hz", json_number(p.partial.frequency_std_hz)},
                        {"frequency_scatter_cents", json_number(p.frequency_scatter_cents)},
                        {"decay_per_s", json_number(p.partial.decay_per_s)},
                        {"decay_std_per_s", json_number(p.partial.decay_std_per_s)},
                        {"decay_scatter", json_number(p.decay_scatter)},
                        {"amplitude", json_number(p.partial.amplitude)},
                        {"amplitude_std", json_number(p.partial.amplitude_std)},
                        {"n_takes", p.n_takes}});
  }
  const Fingerprint& f = reference.fingerprint;
  json rows = json::array(), noise = json::array(), thirds = json::array();
  for (Eigen::Index i = 0; i < f.power.rows(); ++i) {
    json row = json::array();
    for (Eigen::Index t = 0; t < f.power.cols(); ++t) row.push_back(rounded_db(f.power(i, t)));
    rows.push_back(std::move(row));
    noise.push_back(rounded_db(f.noise[i]));
  }
  for (Eigen::Index i = 0; i < f.n_thirds(); ++i) {
    thirds.push_back({{"centre_hz", f.third(i).centre_hz()},
                      {"level_db", rounded_db(f.power.middleRows(4 * i, 4).sum() / static_cast<float>(f.power.cols()))},
                      {"scatter_db", json_number(reference.third_scatter_db[static_cast<std::size_t>(i)])}});
  }
  return {{"schema_version", kReferenceSchema},
          {"kind", "reference_spectrum"},
          {"origin", reference.origin},
          {"n_takes", reference.n_takes},
          {"scatter_dof", reference.scatter_dof},
          {"decay_scatter_dof", reference.decay_scatter_dof},
          {"level_scatter_dof", reference.level_scatter_dof},
          {"common_scatter_cents", reference.common_scatter_cents},
          {"sample_rate_hz", reference.sample_rate_hz},
          {"duration_s", reference.duration_s},
          {"contact_s", reference.contact_s},
          {"band_hz", {reference.band.low_hz, reference.band.high_hz}},
          {"ring_10db_s", reference.ring_10db_s},
          {"partials", std::move(partials)},
          {"occasional_hz", reference.occasional_hz},
          {"third_octaves", std::move(thirds)},
          {"spectrum_scatter_db", reference.spectrum_scatter_db},
          {"fingerprint",
           {{"window_s", f.window_s},
            {"hop_s", f.hop_s},
            {"first_third_octave", f.first_third},
            {"noise_db", std::move(noise)},
            {"levels_db", std::move(rows)}}}};
}

ReferenceSpectrum parse_reference(std::string_view text, const std::string& name) {
  const json root = parse_json(text, name);
  if (!root.is_object() || root.value("kind", json()) != "reference_spectrum") {
    throw InputError(name, "is no reference spectrum", "", "a file that klang regress make wrote");
  }
  const Reader file(root, name);
  if (const int schema = file.integer("schema_version", 1, 1'000'000); schema > kReferenceSchema) {
    throw InputError(name, "was made by a newer klang: schema_version", std::to_string(schema),
                     "up to " + std::to_string(kReferenceSchema));
  }
  ReferenceSpectrum r;
  r.origin = file.text("origin");
  r.n_takes = file.integer("n_takes", 1, 1'000'000);
  r.scatter_dof = file.number("scatter_dof", 0.0, 1e9);
  r.decay_scatter_dof = file.optional_number("decay_scatter_dof", 0.0, 1e9).value_or(r.scatter_dof);
  r.level_scatter_dof = file.optional_number("level_scatter_dof", 0.0, 1e9).value_or(r.n_takes - 1.0);
  r.common_scatter_cents = file.optional_number("common_scatter_cents", 0.0, 1e4).value_or(0.0);
  r.sample_rate_hz = file.number("sample_rate_hz", 1.0, 1e8);
  r.duration_s = file.number("duration_s", 1e-6, 1e6);
  r.contact_s = file.number("contact_s", 0.0, 10.0);
  const std::vector<double> band = file.numbers("band_hz", 0.0, 1e8);
  if (band.size() != 2 || !(band[0] < band[1]))
    throw InputError(name + ".band_hz", "is no band", "", "two rising numbers");
  r.band = {band[0], band[1]};
  r.ring_10db_s = file.number("ring_10db_s", 0.0, 1e9);
  r.occasional_hz = file.numbers("occasional_hz", 0.0, 1e8);
  r.spectrum_scatter_db = file.number("spectrum_scatter_db", 0.0, 1e3);
  const json& partials = file.list("partials");
  if (partials.empty()) throw InputError(name, "has an empty spectrum", "0 partials", "at least 1");
  for (std::size_t i = 0; i < partials.size(); ++i) {
    r.partials.push_back(read_partial(partials[i], name + ", partials[" + std::to_string(i) + "]"));
    if (i > 0 && !(r.partials[i].partial.frequency_hz >= r.partials[i - 1].partial.frequency_hz)) {
      throw InputError(name + ".partials", "do not rise in frequency", std::to_string(i));
    }
  }
  r.fingerprint = read_fingerprint(file.child("fingerprint"));
  const json& thirds = file.list("third_octaves");
  if (static_cast<Eigen::Index>(thirds.size()) != r.fingerprint.n_thirds()) {
    throw InputError(name + ".third_octaves", "does not fit the fingerprint", std::to_string(thirds.size()),
                     std::to_string(r.fingerprint.n_thirds()));
  }
  for (const json& entry : thirds) {
    if (!entry.is_object()) throw InputError(name + ".third_octaves", "holds what is not an object");
    r.third_scatter_db.push_back(Reader(entry, name + ".third_octaves").number("scatter_db", 0.0, 1e3));
  }
  return r;
}

}  // namespace klang::validate
