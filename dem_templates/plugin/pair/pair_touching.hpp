// `pair_style gran` of LIGGGHTS, which looks at all listed pairs in every step: given those that touch. Knows each
// contact as it begins.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <pair_gran_proxy.h>

#include "dem_templates/plugin/lists/near_pairs.hpp"
#include "dem_templates/plugin/pair/pair_rows.hpp"

namespace granary::dem {

/// `model hertz tangential history [rolling_friction epsd2]`, and no word more, is worked out here, several pairs at
/// once; all else by LIGGGHTS, from the particles that have a touching partner. All pairs are still looked at where
/// LIGGGHTS does something for those that do not touch: `contact_distance_factor` above 1, multi-contact models, radii
/// that change, predefined insertion.
class PairTouching : public LAMMPS_NS::PairGranProxy {
 public:
  explicit PairTouching(LAMMPS_NS::LAMMPS* lammps) : PairGranProxy(lammps) {}

  struct Listener {
    /// Hears, once a step, of all that touch and did not at the step before; i is of this rank, j may be a ghost. Two
    /// of two ranks begin on both. What touches when a run starts has begun before it. Places and velocities are those
    /// with which they met: nothing has pushed yet.
    std::function<void(std::span<const NearPairs::Pair>)> begin;
    double largest_overlap = 0.0;  ///< at any step since it was last set, over the smaller radius; of this rank
  };
  /// It is heard as long as it lives.
  void add_listener(const std::shared_ptr<Listener>& listener) { listeners_.push_back(listener); }

  /// Whether those that touched at the last step are all that remember something, and are known.
  bool knows_who_remembers() const;
  /// Those: found(i, j, what they remember), as they were numbered then; j may have been a ghost.
  template <class Found>
  void for_each_that_remembers(Found&& found) const {
    for (const std::uint32_t number : touching_) {
      const NearPairs::Pair& pair = near_.pair(number);
      found(static_cast<int>(pair.i), static_cast<int>(pair.j), remembered(pair));
    }
  }

  /// Particles of this rank then.
  int n_local() const { return n_local_; }

  // What LIGGGHTS calls.
  void settings(int narg, char** arg) override;
  void init_granular() override;
  void compute_force(int energy, int virials, int add) override;

 private:
  bool only_touching_matter() const;
  /// LIGGGHTS has nothing to add to the plain forces of this step.
  bool only_forces_matter(int energy, int virials, int add) const;
  /// The list is a new one.
  void start();
  void push_pairs(int energy, int virials, int add);
  void note_begins();
  template <class Told>
  void for_each_listener(Told&& told);
  void note_overlaps();
  void push();
  void push_queued();
  /// LIGGGHTS' forces of the particles that have a touching partner.
  void let_liggghts_push(int energy, int virials, int add);
  double* remembered(const NearPairs::Pair& pair) const;
  int& flag(const NearPairs::Pair& pair) const;

  bool is_in_rows_ = false;  ///< the law is that of PairRows
  bool forgets_ = false;     ///< two that are apart remember nothing
  std::vector<std::weak_ptr<Listener>> listeners_;
  double largest_overlap_ = 0.0;  ///< in this step

  NearPairs near_;
  std::vector<NearPairs::Pair> listed_;      ///< scratch
  std::span<const std::uint32_t> touching_;  ///< numbers of pairs
  long started_ = -1;                        ///< the list, by its number
  int n_local_ = 0;
  std::uint32_t n_steps_ = 1;              ///< times that forces were worked out
  std::vector<std::uint32_t> touched_at_;  ///< of each pair: n_steps_ when it last touched
  std::vector<NearPairs::Pair> begin_;     ///< scratch: in this step
  std::vector<int> with_partner_;          ///< scratch: particles

  // LIGGGHTS' registry writes through the addresses of these.
  double **young_ = nullptr, **shear_ = nullptr, **damping_ = nullptr, **friction_ = nullptr,
         **rolling_friction_ = nullptr;
  std::size_t n_types_ = 0;                                ///< and the unused 0
  std::vector<ContactMaterial> materials_;                 ///< of type i against type j: [i n_types_ + j]
  PairRows rows_;                                          ///< scratch
  std::array<NearPairs::Pair, PairRows::kMost> queued_{};  ///< of each row
};

}  // namespace granary::dem
