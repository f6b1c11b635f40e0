#include "fit/bubble/bubble_search.hpp"

#include "core/foundation/base/errors.hpp"
#include "fit/bubble/detail/search.hpp"

namespace klang::fit::bubble {

std::vector<RingGroup> ring_groups(const BubbleSearchResult& result, const BubbleSearchOptions& options,
                                   Monitor& monitor) {
  return detail::Search(result.mono, options, monitor).windows(result);
}

BubbleSearchResult find_bubbles(const audio::Signal& recording, const BubbleSearchOptions& options, Monitor& monitor) {
  options.validate();
  if (recording.n_frames() < 256)
    throw InputError(recording.origin, "has too few samples", std::to_string(recording.n_frames()), "256 or more");
  if (!recording.samples.allFinite()) throw InputError(recording.origin, "has a sample that is not finite");
  if (!(recording.samples.cwiseAbs().maxCoeff() > 0.0)) throw InputError(recording.origin, "is silent");
  return detail::Search(recording, options, monitor).run();
}

}  // namespace klang::fit::bubble
