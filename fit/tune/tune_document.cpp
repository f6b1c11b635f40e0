#include "fit/tune/tune_document.hpp"

namespace klang::fit {

TuneDocument tune_document(const TuneResult& result, Provenance provenance) {
  TuneDocument document;
  document.header.kind = "tune";
  document.header.status = to_text(result.status);
  document.header.message = result.message;
  document.header.provenance = std::move(provenance);
  document.header.wall_time_s = result.wall_time_s;
  document.dimensions = result.dimensions;
  for (const TunedTarget& target : result.targets) {
    TunedTargetRecord record{target, {}, {}};
    for (std::size_t d = 0; d < result.dimensions.size(); ++d) {
      record.hz_per_mm[result.dimensions[d].name] = target.hz_per_mm[d];
      record.cents_per_tenth_mm[result.dimensions[d].name] = target.cents_per_tenth_mm[d];
    }
    document.targets.push_back(std::move(record));
  }
  document.n_rounds = result.n_rounds;
  return document;
}

}  // namespace klang::fit
