#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "validate/regression/reference_document.hpp"

namespace klang::validate {
namespace {

using nlohmann::json;

double rounded_db(float power) {
  return std::round(100.0 * std::log10(std::max(static_cast<double>(power), 1e-20))) / 10.0;
}
float power_of(double level_db) { return static_cast<float>(std::pow(10.0, 0.1 * level_db)); }

/// Described lists take null for a number that was not measured; here every one is needed.
void require_numbers(const std::vector<double>& values, const std::string& place) {
  for (const double value : values)
    if (!std::isfinite(value)) throw InputError(place, "holds what is not a number", "null");
}

Fingerprint fingerprint_of(const FingerprintRecord& record, const std::string& place) {
  Fingerprint f;
  f.window_s = record.window_s;
  f.hop_s = record.hop_s;
  f.first_third = record.first_third_octave;
  const auto& rows = record.levels_db;
  if (rows.empty() || rows.size() % 4 != 0 || rows.size() != record.noise_db.size()) {
    throw InputError(place, "has the wrong number of bands", std::to_string(rows.size()),
                     "a multiple of 4, as in noise_db");
  }
  require_numbers(record.noise_db, place + ".noise_db");
  f.noise.resize(static_cast<Eigen::Index>(rows.size()));
  f.power.resize(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.front().size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].empty() || static_cast<Eigen::Index>(rows[i].size()) != f.power.cols()) {
      throw InputError(place + ".levels_db", "has rows of different lengths", std::to_string(rows[i].size()));
    }
    require_numbers(rows[i], place + ".levels_db");
    const auto band = static_cast<Eigen::Index>(i);
    for (std::size_t t = 0; t < rows[i].size(); ++t) f.power(band, static_cast<Eigen::Index>(t)) = power_of(rows[i][t]);
    f.noise[band] = power_of(record.noise_db[i]);
  }
  return f;
}

FingerprintRecord record_of(const Fingerprint& f) {
  FingerprintRecord record{f.window_s, f.hop_s, f.first_third, {}, {}};
  for (Eigen::Index i = 0; i < f.power.rows(); ++i) {
    std::vector<double>& row = record.levels_db.emplace_back();
    for (Eigen::Index t = 0; t < f.power.cols(); ++t) row.push_back(rounded_db(f.power(i, t)));
    record.noise_db.push_back(rounded_db(f.noise[i]));
  }
  return record;
}

ReferencePartial partial_of(const ReferencePartialRecord& record) {
  ReferencePartial p;
  p.partial.frequency_hz = record.frequency_hz;
  p.partial.frequency_std_hz = record.frequency_std_hz;
  p.partial.decay_per_s = record.decay_per_s;
  p.partial.decay_std_per_s = record.decay_std_per_s;
  p.partial.amplitude = record.amplitude;
  p.partial.amplitude_std = record.amplitude_std;
  p.frequency_scatter_cents = record.frequency_scatter_cents;
  p.decay_scatter = record.decay_scatter;
  p.n_takes = record.n_takes;
  return p;
}

ReferencePartialRecord record_of(const ReferencePartial& p) {
  ReferencePartialRecord record;
  record.frequency_hz = p.partial.frequency_hz;
  record.frequency_std_hz = p.partial.frequency_std_hz.value_or(0.0);
  record.frequency_scatter_cents = p.frequency_scatter_cents;
  record.decay_per_s = p.partial.decay_per_s;
  record.decay_std_per_s = p.partial.decay_std_per_s;
  record.decay_scatter = p.decay_scatter;
  record.amplitude = p.partial.amplitude;
  record.amplitude_std = p.partial.amplitude_std;
  record.n_takes = p.n_takes;
  return record;
}

}  // namespace

ReferenceRecord record_of(const ReferenceSpectrum& reference) {
  ReferenceRecord record;
  record.origin = reference.origin;
  record.n_takes = reference.n_takes;
  record.scatter_dof = reference.scatter_dof;
  record.decay_scatter_dof = reference.decay_scatter_dof;
  record.level_scatter_dof = reference.level_scatter_dof;
  record.common_scatter_cents = reference.common_scatter_cents;
  record.sample_rate_hz = reference.sample_rate_hz;
  record.duration_s = reference.duration_s;
  record.contact_s = reference.contact_s;
  record.band_hz = {reference.band.low_hz, reference.band.high_hz};
  record.ring_10db_s = reference.ring_10db_s;
  for (const ReferencePartial& p : reference.partials) record.partials.push_back(record_of(p));
  record.occasional_hz = reference.occasional_hz;
  const Fingerprint& f = reference.fingerprint;
  for (Eigen::Index i = 0; i < f.n_thirds(); ++i) {
    const float mean = f.power.middleRows(4 * i, 4).sum() / static_cast<float>(f.power.cols());
    record.third_octaves.push_back(
        {f.third(i).centre_hz(), rounded_db(mean), reference.third_scatter_db[static_cast<std::size_t>(i)]});
  }
  record.spectrum_scatter_db = reference.spectrum_scatter_db;
  record.fingerprint = record_of(f);
  return record;
}

json to_json(const ReferenceSpectrum& reference) {
  json object = {{"schema_version", kReferenceSchema}, {"kind", "reference_spectrum"}};
  write_fields(object, record_of(reference));
  return object;
}

ReferenceSpectrum parse_reference(std::string_view text, const std::string& name) {
  const json root = parse_json(text, name);
  if (!root.is_object() || root.value("kind", json()) != "reference_spectrum") {
    throw InputError(name, "is no reference spectrum", "", "a file that klang regress make wrote");
  }
  const json schema = root.value("schema_version", json());
  if (!schema.is_number_integer() || schema < 1 || schema > kReferenceSchema) {
    throw InputError(name, "was made by a newer klang: schema_version", schema.dump().substr(0, 20),
                     "1 to " + std::to_string(kReferenceSchema));
  }
  const auto record = read_fields<ReferenceRecord>(root, name);
  ReferenceSpectrum r;
  r.origin = record.origin;
  r.n_takes = record.n_takes;
  r.scatter_dof = record.scatter_dof;
  r.decay_scatter_dof = record.decay_scatter_dof.value_or(r.scatter_dof);
  r.level_scatter_dof = record.level_scatter_dof.value_or(r.n_takes - 1.0);
  r.common_scatter_cents = record.common_scatter_cents.value_or(0.0);
  r.sample_rate_hz = record.sample_rate_hz;
  r.duration_s = record.duration_s;
  r.contact_s = record.contact_s;
  if (record.band_hz.size() != 2 || !(record.band_hz[0] < record.band_hz[1]))
    throw InputError(name + ".band_hz", "is no band", "", "two rising numbers");
  r.band = {record.band_hz[0], record.band_hz[1]};
  r.ring_10db_s = record.ring_10db_s;
  require_numbers(record.occasional_hz, name + ".occasional_hz");
  r.occasional_hz = record.occasional_hz;
  r.spectrum_scatter_db = record.spectrum_scatter_db;
  if (record.partials.empty()) throw InputError(name, "has an empty spectrum", "0 partials", "at least 1");
  for (const ReferencePartialRecord& p : record.partials) {
    if (!r.partials.empty() && !(p.frequency_hz >= r.partials.back().partial.frequency_hz)) {
      throw InputError(name + ".partials", "do not rise in frequency", std::to_string(r.partials.size()));
    }
    r.partials.push_back(partial_of(p));
  }
  r.fingerprint = fingerprint_of(record.fingerprint, name + ".fingerprint");
  if (static_cast<Eigen::Index>(record.third_octaves.size()) != r.fingerprint.n_thirds()) {
    throw InputError(name + ".third_octaves", "does not fit the fingerprint",
                     std::to_string(record.third_octaves.size()), std::to_string(r.fingerprint.n_thirds()));
  }
  for (const ThirdOctaveRecord& third : record.third_octaves) r.third_scatter_db.push_back(third.scatter_db);
  return r;
}

}  // namespace klang::validate
