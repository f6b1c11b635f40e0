#include "reports/kit/result_data.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "reports/kit/json_node.hpp"
#include "reports/kit/text.hpp"

namespace klang::reports::detail {
namespace {

using nlohmann::json;

Estimate estimate(const Node& node) {
  Estimate result;
  result.name = node.text("name");
  result.value = node.number("value");
  result.std = node.number("std");
  const std::vector<double> interval = node.numbers("ci95");
  if (interval.size() == 2) result.ci95 = {interval[0], interval[1]};
  result.identifiable = node.boolean("identifiable").value_or(false);
  result.why = node.text("why");
  result.start_value = node.number("start_value");
  result.derived = node.boolean("derived").value_or(false);
  return result;
}

Partial partial(const Node& node) {
  Partial result;
  result.frequency_hz = node.required("frequency_hz");
  result.frequency_std_hz = node.number("frequency_std_hz");
  result.decay_per_s = node.number("decay_per_s");
  result.decay_std_per_s = node.number("decay_std_per_s");
  result.amplitude = node.number("amplitude");
  result.amplitude_std = node.number("amplitude_std");
  result.phase_rad = node.number("phase_rad");
  result.phase_std_rad = node.number("phase_std_rad");
  result.matched_mode = node.integer("matched_mode");
  return result;
}

/// "tube, length 505 mm, ..." from an object (its numbers, also those of an inner "dims") or a plain text.
void describe_shape(const Node& node, std::string& words, std::string& kind) {
  const json& shape = node.raw();
  if (shape.is_string()) {
    words = shape.get<std::string>();
    return;
  }
  if (!shape.is_object()) return;
  if (node.has("kind")) words = kind = node.text("kind");
  if (node.has("mesh")) words += (words.empty() ? "mesh " : ", mesh ") + node.text("mesh");
  if (node.has("profile_csv")) words += ", profile " + node.text("profile_csv");
  const json& dims = node.has("dims") && shape.at("dims").is_object() ? shape.at("dims") : shape;
  // As a person gives them: the largest dimensions first, unknown ones last.
  static constexpr std::array<std::string_view, 13> kOrder = {
      "edge_m", "length_m", "width_m", "height_m", "outer_radius_m", "radius_m",  "a_m",
      "b_m",    "c_m",      "depth_m", "wall_m",   "thickness_m",    "max_edge_m"};
  std::vector<std::pair<std::string, double>> sorted;
  for (const auto& [key, value] : dims.items()) {
    if (value.is_number()) sorted.emplace_back(key, value.get<double>());
  }
  const auto rank = [](const auto& entry) {
    return std::find(kOrder.begin(), kOrder.end(), entry.first) - kOrder.begin();
  };
  std::stable_sort(sorted.begin(), sorted.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  for (const auto& [key, value] : sorted) {
    const Quantity shown_as = quantity(key, value);
    words +=
        (words.empty() ? "" : ", ") + shown_as.words + " " + rounded(value * shown_as.factor, 5) + " " + shown_as.unit;
  }
}

void read_files(const Node& node, Specimen& specimen) {
  const Node files = node.child("files");
  specimen.recording = files.text("recording");
  specimen.resynthesis = files.text("resynthesis");
  specimen.modes_file = files.text("modes");
}

/// What a specimen of a fit and the top level of the other kinds have in common.
Specimen read_body(const Node& node) {
  Specimen specimen;
  specimen.name = node.text("name");
  describe_shape(node.child("shape"), specimen.shape, specimen.shape_kind);
  specimen.mass_kg = node.number("mass_kg");
  specimen.rms_deviation_cents = node.number("rms_deviation_cents");
  specimen.max_deviation_cents = node.number("max_deviation_cents");
  specimen.explained_energy = node.number("explained_energy");
  specimen.noise_rms = node.number("noise_rms");
  specimen.sample_rate_hz = node.number("sample_rate_hz");
  specimen.duration_s = node.number("duration_s");
  specimen.n_nodes = node.integer("n_nodes");
  specimen.n_elements = node.integer("n_elements");
  specimen.n_channels = node.integer("n_channels");
  specimen.none_missing = node.boolean("none_missing");
  specimen.predicted = node.boolean("predicted").value_or(false);
  specimen.n_rigid_modes = node.integer("n_rigid_modes");
  specimen.element = node.text("element");
  specimen.strikes_s = node.numbers("strikes_s");
  node.each("partials", [&](const Node& entry) { specimen.partials.push_back(partial(entry)); });
  node.each("modes", [&](const Node& entry) {
    specimen.modes.push_back({entry.integer("index").value_or(static_cast<int>(specimen.modes.size())),
                              entry.required("frequency_hz"), entry.number("relative_residual")});
  });
  read_files(node, specimen);
  return specimen;
}

void read_fit(const Node& root, ResultData& data) {
  const Node material = root.child("material");
  if (material.raw().is_object()) {
    data.material = material.has("preset") ? material.text("preset") : material.text("name");
    data.density_kg_m3 = material.number("density_kg_m3");
  } else if (material.raw().is_string()) {
    data.material = material.raw().get<std::string>();
  }
  root.each("parameters", [&](const Node& node) { data.parameters.push_back(estimate(node)); });
  const Node correlation = root.child("correlation");
  data.correlation_names = correlation.texts("names");
  correlation.each("matrix", [&](const Node& row) {
    std::vector<Number> values;
    if (!row.raw().is_array()) throw InputError(row.place(), "not a list");
    for (const json& value : row.raw()) {
      values.push_back(value.is_number() ? Number(value.get<double>()) : Number());
    }
    data.correlation.push_back(std::move(values));
  });
  const Node damping = root.child("damping");
  data.damping_model = damping.text("model");
  damping.each("candidates", [&](const Node& node) {
    DampingModel model;
    model.model = node.text("model");
    node.each("parameters", [&](const Node& entry) { model.parameters.push_back(estimate(entry)); });
    model.aicc = node.number("aicc");
    model.aicc_weight = node.number("aicc_weight");
    model.rms_relative_residual = node.number("rms_relative_residual");
    const Node curve = node.child("curve");
    model.curve_frequency_hz = curve.numbers("frequency_hz");
    model.curve_decay_per_s = curve.numbers("decay_per_s");
    if (model.curve_frequency_hz.size() != model.curve_decay_per_s.size()) {
      throw InputError(curve.place(), "frequency_hz and decay_per_s differ in length");
    }
    data.damping.push_back(std::move(model));
  });
  root.each("matches", [&](const Node& node) {
    Match match;
    match.specimen = node.text("specimen");
    match.mode_index = node.integer("mode_index").value_or(-1);
    match.frequency_hz = node.required("frequency_hz");
    match.model_frequency_hz = node.required("model_frequency_hz");
    match.deviation_cents = node.required("deviation_cents");
    match.frequency_std_hz = node.number("frequency_std_hz");
    match.decay_per_s = node.number("decay_per_s");
    match.decay_std_per_s = node.number("decay_std_per_s");
    match.model_decay_per_s = node.number("model_decay_per_s");
    match.radiation_decay_per_s = node.number("radiation_decay_per_s");
    match.mount_decay_per_kg = node.number("mount_decay_per_kg");
    match.model_frequency_std_hz = node.number("model_frequency_std_hz");
    data.matches.push_back(match);
  });
  root.each("predicted", [&](const Node& node) {
    data.predicted.push_back({node.text("specimen"), node.integer("mode_index").value_or(-1),
                              node.required("frequency_hz"), node.number("decay_per_s")});
  });
  root.each("specimens", [&](const Node& node) { data.specimens.push_back(read_body(node)); });
  data.cost_initial = root.number("cost_initial");
  data.cost_final = root.number("cost_final");
  data.n_iterations = root.number("n_iterations");
}

StudySeries read_series(const Node& node) {
  StudySeries series;
  series.id = node.text("id");
  series.title = node.text("title");
  series.reference = node.text("reference");
  series.step = node.text("step");
  series.error = node.text("error");
  series.kind = node.text("kind");
  series.floor = node.text("floor");
  series.verdict = node.text("verdict");
  series.observed_order = node.number("observed_order");
  series.expected_order = node.number("expected_order");
  series.order_tolerance = node.number("order_tolerance");
  series.error_tolerance = node.number("error_tolerance");
  series.error_floor = node.number("error_floor");
  const std::vector<double> interval = node.numbers("order_ci95");
  if (interval.size() == 2) series.order_ci95 = {interval[0], interval[1]};
  series.asymptotic = node.boolean("asymptotic");
  series.counts = node.boolean("counts").value_or(true);
  series.passed = node.boolean("passed").value_or(false);
  series.higher_is_fine = node.boolean("higher_is_fine").value_or(false);
  const Node gci = node.child("gci");
  series.gci_order = gci.number("order");
  series.gci_fine = gci.number("gci_fine");
  series.gci_ratio = gci.number("asymptotic_ratio");
  series.gci_extrapolated = gci.number("extrapolated");
  series.gci_exact = gci.number("exact");
  node.each("levels", [&](const Node& level) {
    series.levels.push_back({level.number("h_m"), level.number("n"), level.number("error"), level.number("value"),
                             level.number("n_unknowns"), level.number("pairwise_order"), level.text("excluded")});
  });
  return series;
}

std::vector<StudyClaim> read_claims(const Node& root) {
  std::vector<StudyClaim> claims;
  root.each("claims", [&](const Node& node) {
    claims.push_back({node.text("name"), node.text("words"), node.number("measured"), node.number("reference"),
                      node.number("tolerance"), node.boolean("passed").value_or(false), node.text("not_judged")});
  });
  return claims;
}

void read_study(const Node& root, StudyData& study) {
  study.name = root.text("study");
  study.title = root.text("title");
  study.question = root.text("question");
  study.passed = root.boolean("passed").value_or(false);
  root.each("series", [&](const Node& node) { study.series.push_back(read_series(node)); });
  study.claims = read_claims(root);
  const Node fields = root.child("fields");
  const auto read_fields = [&](const char* key, FieldKind kind) {
    fields.each(key, [&](const Node& node) {
      study.fields.push_back({kind, node.text("name"), node.text("title"), node.text("caption"), node.text("file"),
                              node.text("quantity"), node.boolean("decibels").value_or(false),
                              node.number("floor").value_or(0.0)});
    });
  };
  read_fields("slices", FieldKind::kSlice);
  read_fields("surfaces", FieldKind::kSurface);
  read_fields("balloons", FieldKind::kBalloon);
}

void read_provenance(const Node& root, ResultData& data) {
  const Node node = root.child("provenance");
  data.version = node.text("version");
  data.command = node.text("command");
  if (node.has("seed")) data.seed = node.raw().at("seed").dump();
  if (node.has("options")) {
    data.options = node.raw().at("options").dump(2, ' ', false, json::error_handler_t::replace);
  }
  node.each("inputs", [&](const Node& input) {
    data.inputs.push_back({input.text("path"), input.text("sha256"), input.number("n_bytes")});
  });
  if (root.has("wall_time_s") && root.raw().at("wall_time_s").is_object()) {
    for (const auto& [key, value] : root.raw().at("wall_time_s").items()) {
      if (value.is_number()) data.wall_time_s.emplace_back(key, value.get<double>());
    }
  }
}

void read_bubbles(const Node& root, BubbleData& data) {
  for (const bool is_bubble : {true, false}) {
    root.each(is_bubble ? "bubbles" : "rejected", [&](const Node& node) {
      BubbleRow row;
      row.is_bubble = is_bubble;
      row.onset_s = node.required("onset_s");
      row.end_s = node.required("end_s");
      row.frequency_start_hz = node.required("frequency_start_hz");
      row.frequency_end_hz = node.required("frequency_end_hz");
      row.decay_per_s = node.required("decay_per_s");
      row.radius_m = node.required("radius_m");
      row.frequency_std_hz = node.number("frequency_start_std_hz");
      row.decay_std_per_s = node.number("decay_std_per_s");
      row.theory_decay_per_s = node.number("theory_decay_per_s");
      row.radius_std_m = node.number("radius_std_m");
      row.snr_db = node.number("snr_db");
      row.verdict = node.text("verdict");
      row.track_time_s = node.child("track").numbers("time_s");
      row.track_frequency_hz = node.child("track").numbers("frequency_hz");
      if (row.track_time_s.size() != row.track_frequency_hz.size())
        throw InputError(node.place() + ".track", "lists differ in length");
      data.rows.push_back(std::move(row));
    });
  }
  const Node theory = root.child("theory"), pitch = root.child("pitch");
  data.theory_frequency_hz = theory.numbers("frequency_hz");
  data.theory_decay_per_s = theory.numbers("decay_per_s");
  if (data.theory_frequency_hz.size() != data.theory_decay_per_s.size())
    throw InputError(theory.place(), "lists differ in length");
  data.pitch_status = pitch.text("status");
  data.pitch_message = pitch.text("message");
  pitch.each("parameters", [&](const Node& node) { data.pitch.push_back(estimate(node)); });
  pitch.each("identifiable", [&](const Node& node) {
    data.pitch.push_back(estimate(node));
    data.pitch.back().name = node.text("combination");
    data.pitch.back().derived = true;
  });
}

std::vector<std::vector<double>> read_levels(const Node& node, const char* key, std::size_t n_rows,
                                             std::size_t n_columns) {
  std::vector<std::vector<double>> rows;
  node.each(key, [&](const Node& row) {
    if (!row.raw().is_array() || row.raw().size() != n_columns) throw InputError(row.place(), "has the wrong length");
    rows.emplace_back();
    for (const json& value : row.raw()) {
      if (!value.is_number()) throw InputError(row.place(), "not a number");
      rows.back().push_back(value.get<double>());
    }
  });
  if (rows.size() != n_rows) throw InputError(node.place() + "." + key, "has the wrong number of bands");
  return rows;
}

void read_regression(const Node& root, RegressionData& data) {
  data.claims = read_claims(root);
  root.each("partials", [&](const Node& node) {
    RegressionPartial p;
    if (node.has("reference")) p.reference = partial(node.child("reference"));
    if (node.has("sound")) p.sound = partial(node.child("sound"));
    if (!p.reference && !p.sound) throw InputError(node.place(), "has neither reference nor sound");
    p.cents = node.number("cents");
    p.cents_tolerance = node.number("cents_tolerance");
    p.decay_change = node.number("decay_change");
    p.decay_tolerance = node.number("decay_tolerance");
    p.note = node.text("note");
    data.partials.push_back(std::move(p));
  });
  root.each("third_octaves", [&](const Node& node) {
    data.thirds.push_back({node.required("centre_hz"), node.number("reference_db"), node.number("sound_db"),
                           node.number("difference_db"), node.number("tolerance_db")});
  });
  data.reference_origin = root.text("reference_origin");
  data.reference_takes = root.integer("reference_takes");
  data.gain_db = root.number("gain_db");
  data.factor = root.number("factor");
  data.log_spectral_distance_db = root.number("log_spectral_distance_db");
  data.ring_10db_s = root.number("ring_10db_s");
  data.reference_ring_10db_s = root.number("reference_ring_10db_s");
  const Node levels = root.child("spectrogram");
  data.times_s = levels.numbers("times_s");
  data.bands_hz = levels.numbers("bands_hz");
  data.reference_db = read_levels(levels, "reference_db", data.bands_hz.size(), data.times_s.size());
  data.sound_db = read_levels(levels, "sound_db", data.bands_hz.size(), data.times_s.size());
}

void read_papers(const Node& root, PapersData& data) {
  root.each("numbers", [&](const Node& node) {
    data.numbers.push_back({node.text("paper"), node.text("place"), node.text("quantity"),
                            node.text("reference_source"), node.text("tolerance_source"), node.text("note"),
                            node.text("verdict"), node.number("printed"), node.number("ours"), node.number("reference"),
                            node.number("tolerance")});
  });
  root.each("not_computed", [&](const Node& node) {
    data.gaps.push_back({node.text("paper"), node.text("place"), node.text("reason")});
  });
}

std::vector<std::pair<std::string, double>> read_stages(const Node& node) {
  std::vector<std::pair<std::string, double>> stages;
  if (!node.raw().is_object()) return stages;
  for (const auto& [name, value] : node.raw().items())
    stages.emplace_back(name.substr(0, name.rfind("_s")), node.required(name.c_str()));
  return stages;
}

void read_proxy_study(const Node& root, ProxyStudyData& data) {
  root.each("pieces", [&](const Node& node) {
    ProxyPieceRow row;
    row.name = node.text("name");
    row.lowest_hz = node.required("lowest_hz");
    row.lowest_direct_hz = node.number("lowest_direct_hz");
    row.n_modes = node.integer("modes").value_or(0);
    row.n_proxy_modes = node.integer("proxy_modes").value_or(0);
    row.bank_too_short = node.boolean("bank_too_short").value_or(false);
    row.clamped = node.boolean("clamped").value_or(false);
    const Node errors = node.child("errors");
    row.partial_rms_cents = errors.number("partial_rms_cents");
    row.log_spectral_distance_db = errors.number("log_spectral_distance_db");
    row.mel_distance_db = errors.number("mel_distance_db");
    row.third_octave_db = errors.number("third_octave_db");
    row.loudness_difference_db = errors.number("loudness_difference_db");
    data.pieces.push_back(std::move(row));
  });
  root.each("thresholds", [&](const Node& node) {
    ProxyThresholdRow row;
    row.threshold_hz = node.required("threshold_hz");
    row.modes_replaced_percent = node.required("modes_replaced_percent");
    row.n_replaced = node.integer("replaced").value_or(0);
    row.log_spectral_distance_db = node.number("log_spectral_distance_db");
    row.mel_distance_db = node.number("mel_distance_db");
    row.third_octave_db = node.number("third_octave_db");
    row.loudness_difference_db = node.number("loudness_difference_db");
    data.thresholds.push_back(row);
  });
  const Node timings = root.child("timings");
  std::size_t i = 0;
  timings.each("pieces", [&](const Node& node) {
    if (i < data.pieces.size()) {
      data.pieces[i].direct_s = node.number("direct_s");
      data.pieces[i].proxy_s = node.number("proxy_s");
    }
    ++i;
  });
  i = 0;
  timings.each("thresholds", [&](const Node& node) {
    if (i < data.thresholds.size()) {
      data.thresholds[i].direct_s = node.number("direct_s");
      data.thresholds[i].with_proxies_s = node.number("with_proxies_s");
    }
    ++i;
  });
  data.direct_stages = read_stages(timings.child("direct_stages"));
  data.proxy_stages = read_stages(timings.child("proxy_stages"));
  data.speedup = timings.number("speedup");
  data.speedup_without_lowest = timings.number("speedup_without_lowest");
  data.direct_sound = root.text("direct_sound");
  data.proxy_sound = root.text("proxy_sound");
}

void read_proxy_fit(const Node& root, ProxyFitData& data) {
  const Node before = root.child("before"), after = root.child("after"), worse = root.child("n_worse");
  for (const char* name : {"partial_rms_cents", "log_spectral_distance_db", "mel_distance_db", "third_octave_db",
                           "loudness_difference_db", "decay_rms_percent"})
    data.measures.push_back({name, before.required(name), after.required(name), worse.integer(name)});
  const auto read_ellipsoid = [](const Node& node) {
    const std::vector<double> axes = node.numbers("axes");
    if (axes.size() != 3) throw InputError(node.place() + ".axes", "needs three numbers");
    ProxyFitData::Ellipsoid e;
    e.scale_m = node.required("scale_m");
    for (std::size_t i = 0; i < 3; ++i) e.axes_m[i] = axes[i] * e.scale_m;
    e.rayleigh_mass_per_s = node.required("rayleigh_mass_per_s");
    e.rayleigh_stiffness_s = node.required("rayleigh_stiffness_s");
    e.gain = node.required("gain");
    return e;
  };
  data.start = read_ellipsoid(root.child("start"));
  data.fitted = read_ellipsoid(root.child("fitted"));
  root.each("partials", [&](const Node& node) {
    for (const auto& [who, list] :
         {std::pair{"target", &data.target}, {"before", &data.before}, {"after", &data.after}}) {
      const std::string prefix = std::string(who) + "_";
      list->push_back({node.required((prefix + "hz").c_str()), node.required((prefix + "decay_per_s").c_str()),
                       node.required((prefix + "amplitude").c_str())});
    }
  });
  data.n_fitted = root.integer("n_fitted").value_or(0);
  data.least_partial_rms_cents = root.number("least_partial_rms_cents");
  data.n_candidates = root.integer("n_candidates");
  data.n_refused = root.integer("n_refused");
  data.improved = root.boolean("improved").value_or(false);
  data.sound = root.text("sound");
  data.loudness = root.text("loudness");
  data.target_kind = root.text("target_kind");
}

}  // namespace

ResultData read_result(const std::filesystem::path& result_json) {
  const std::string place = result_json.string();
  const std::string bytes = read_file(result_json, std::size_t{1} << 30);
  const json parsed = json::parse(bytes, nullptr, false);
  if (parsed.is_discarded()) throw InputError(place, "not JSON");
  if (!parsed.is_object()) throw InputError(place, "not a result file");
  const Node root(parsed, place);
  if (root.integer("schema_version").value_or(0) != 1) {
    throw InputError(place + ".schema_version", "cannot be read", root.child("schema_version").raw().dump(), "1");
  }
  ResultData data;
  data.kind = root.text("kind");
  if (data.kind != "fit" && data.kind != "analysis" && data.kind != "modes" && data.kind != "study" &&
      data.kind != "bubbles" && data.kind != "regression" && data.kind != "papers" && data.kind != "proxy_study" &&
      data.kind != "proxy_fit") {
    throw InputError(place + ".kind", "has no report", data.kind,
                     "fit, analysis, modes, study, bubbles, regression, papers, proxy_study, proxy_fit");
  }
  data.name = root.text("name");
  data.status = root.text("status");
  data.message = root.text("message");
  data.warnings = root.texts("warnings");
  data.peak_memory_bytes = root.number("peak_memory_bytes");
  if (data.kind == "fit") {
    read_fit(root, data);
  } else if (data.kind == "study") {
    read_study(root, data.study);
  } else if (data.kind == "regression") {
    read_regression(root, data.regression);
  } else if (data.kind == "papers") {
    read_papers(root, data.papers);
  } else if (data.kind == "proxy_study") {
    read_proxy_study(root, data.proxy_study);
  } else if (data.kind == "proxy_fit") {
    read_proxy_fit(root, data.proxy);
  } else {
    data.specimens.push_back(read_body(root));
    if (data.kind == "bubbles") read_bubbles(root, data.bubbles);
  }
  read_provenance(root, data);
  return data;
}

MatchSummary match_summary(const ResultData& data, bool predicted) {
  MatchSummary summary;
  double sum_sq = 0.0;
  for (const Specimen& specimen : data.specimens) {
    if (specimen.predicted != predicted) continue;
    summary.n_partials += specimen.partials.size();
    for (const Match& match : data.matches) {
      if (match.specimen != specimen.name) continue;
      ++summary.n_matched;
      sum_sq += match.deviation_cents * match.deviation_cents;
      if (!summary.worst || std::abs(match.deviation_cents) > std::abs(summary.worst->deviation_cents))
        summary.worst = &match;
    }
  }
  summary.n_partials = std::max(summary.n_partials, summary.n_matched);
  if (summary.n_matched > 0) summary.rms_cents = std::sqrt(sum_sq / static_cast<double>(summary.n_matched));
  return summary;
}

}  // namespace klang::reports::detail
