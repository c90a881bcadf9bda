// How much of the bench is done.
#pragma once

namespace granary::pbm::bench {

enum class Effort {
  quick,  ///< all parts within about 20 s: few repetitions, the reference's long runs left out
  usual,  ///< about 3 minutes
  full    ///< also what the reference needs many minutes for
};

/// One value for each effort.
template <class T>
T by_effort(Effort effort, T quick, T usual, T full) {
  return effort == Effort::quick ? quick : effort == Effort::usual ? usual : full;
}

}  // namespace granary::pbm::bench
