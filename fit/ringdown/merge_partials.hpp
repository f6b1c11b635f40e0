#pragma once
#include <vector>

#include "fit/ringdown/partial_table.hpp"

namespace klang::fit {

/// Partials of several recordings of one body as one table. Partials that agree (three standard deviations, at least
/// min_cents) become their inverse-variance mean; where they scatter by more than their standard deviations say, the scatter
/// enters the mean's standard deviation (Birge ratio). Amplitude and phase are the loudest one's.
PartialTable merge_partials(const std::vector<PartialTable>& tables, double min_cents = 3.0);

/// How takes of one body agree.
struct TakeAgreement {
  double scatter = 0.0;      ///< of ln f from take to take, beyond the partials' own deviations
  double least_share = 1.0;  ///< of a take's strong partials (to -26 dB), those that another take has too: the least
};
TakeAgreement take_agreement(const std::vector<PartialTable>& tables, double min_cents = 3.0);

}  // namespace klang::fit
