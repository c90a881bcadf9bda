// A search that knows a list of points, first sown over the cube: differential evolution, ensemble Kalman inversion.
#pragma once

#include <vector>

#include "estimation/search/methods.hpp"

namespace granary::estimation {

class Population : public Search {
 protected:
  /// `most`: members. The first of them is `start`, the others are anywhere.
  Population(const Point& start, std::uint64_t seed, std::size_t most)
      : n_(start.size()), dice_(seed), most_(most), start_(start) {}

  struct Member {
    Point at;
    Residuals residuals;
    double cost;
  };

  bool full() const { return members_.size() == most_; }
  /// Enough have been asked for, and `least` of them are known.
  bool sown(std::size_t least) const { return sown_ >= most_ && members_.size() >= least; }
  Point sow() { return sown_++ == 0 ? start_ : dice_.anywhere(n_); }
  const Member& any() { return members_[static_cast<std::size_t>(dice_.below(static_cast<int>(members_.size())))]; }

  std::size_t n_;  ///< parameters
  Dice dice_;
  std::size_t most_, turn_ = 0;
  std::vector<Member> members_;

 private:
  std::size_t sown_ = 0;
  Point start_;
};

}  // namespace granary::estimation
