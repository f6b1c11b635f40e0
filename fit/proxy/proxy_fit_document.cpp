#include "fit/proxy/proxy_fit_document.hpp"

#include <algorithm>

namespace klang::fit {
namespace {

EllipsoidRecord ellipsoid_record(const ProxyParameters& p) {
  return {{p.axes[0], p.axes[1], p.axes[2]}, p.scale_m, p.damping.mass_per_s, p.damping.stiffness_s, p.gain};
}

std::vector<ParameterRecord> parameter_records(const ProxyParameters& a, const ProxyParameters& b) {
  return {{"shape_a_over_c", a.axes[0] / a.axes[2], b.axes[0] / b.axes[2]},
          {"shape_b_over_c", a.axes[1] / a.axes[2], b.axes[1] / b.axes[2]},
          {"scale_m", a.scale_m, b.scale_m},
          {"rayleigh_mass_per_s", a.damping.mass_per_s, b.damping.mass_per_s},
          {"rayleigh_stiffness_s", a.damping.stiffness_s, b.damping.stiffness_s},
          {"gain", a.gain, b.gain}};
}

}  // namespace

ProxyFitDocument proxy_fit_document(ResultHeader header, const ProxyFitResult& result) {
  ProxyFitDocument document;
  document.header = std::move(header);
  document.header.message = result.message;
  document.loudness = "A-weighted energy (IEC 61672-1), absolute difference";
  document.before = result.before;
  document.after = result.after;
  document.improved = result.status == ProxyFitStatus::kImproved;
  document.start = ellipsoid_record(result.start);
  document.fitted = ellipsoid_record(result.fitted);
  document.parameters = parameter_records(result.start, result.fitted);
  document.n_fitted = result.n_partials;
  const auto n = std::min({result.target.size(), result.start_voice.size(), result.fitted_voice.size()});
  for (std::size_t k = 0; k < n; ++k)
    document.partials.push_back({result.target[k], result.start_voice[k], result.fitted_voice[k]});
  document.least_partial_rms_cents = result.least_cents;
  document.n_candidates = result.n_candidates;
  document.n_refused = result.n_refused;
  const auto& worse = result.n_worse;
  document.n_worse = {worse[0], worse[1], worse[2], worse[3], worse[4]};
  return document;
}

}  // namespace klang::fit
