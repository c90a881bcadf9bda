// fix ID GROUP granary/wall: walls that push particles, each in a frame of its own that may turn. Where they are
// touched is surface.hpp, how they push contact_law.hpp; here both meet LIGGGHTS. Syntax: docs/dem_styles.md.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fix.h>

#include "common/result.hpp"
#include "dem_templates/plugin/input/fix_arguments.hpp"
#include "dem_templates/plugin/wall/touch_book.hpp"
#include "dem_templates/plugin/wall/wall_rows.hpp"
#include "dem_templates/plugin/wall/wall_settings.hpp"
#include "dem_templates/plugin/wall/watch.hpp"
#include "dem_templates/plugin/walls.hpp"

namespace granary::dem {

class FixWall : public LAMMPS_NS::Fix {
 public:
  FixWall(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);
  ~FixWall() override;

  std::vector<std::string> body_names() const;
  /// The named body for the tally and the guard; nullptr if there is none. Lives no longer than this fix.
  std::unique_ptr<Wall> body(const std::string& name);

  /// Of a particle of this rank with all bodies, at the last step.
  std::size_t n_touches(int particle) const { return book_.page(static_cast<std::size_t>(particle)).n; }

  /// The largest overlap with a body at any step since the last call, over the particle's radius; of this rank.
  double take_largest_overlap();

  /// Hears of each impact of this rank as it begins: body (its place in body_names()), particle, normal speed [m/s].
  using ImpactListener = std::function<void(std::size_t body, int particle, double speed)>;
  /// There is one listener; an empty one takes its place when it goes.
  void set_listener(ImpactListener listener) { listener_ = std::move(listener); }
  /// Hears of each touch of this rank in each step: body, particle, overlap over its radius. Of these there is one too.
  using TouchListener = std::function<void(std::size_t body, int particle, double overlap)>;
  void set_touch_listener(TouchListener listener) { touch_listener_ = std::move(listener); }

  /// What this rank's particles do to a body in this step.
  struct Load {
    Vector3 force{};            ///< [N]
    Vector3 torque{};           ///< about its origin [N m]
    double axial_torque = 0.0;  ///< about its axis [N m]
    double power = 0.0;         ///< that the body gives to the particles [W]
  };
  Load load(std::size_t body) const;

  /// Its triangles where they stand at this step; none of a plane or a cylinder.
  std::vector<Triangle> triangles(std::size_t body);

  // What LIGGGHTS calls.
  int setmask() override;
  void init() override;
  void setup(int) override;
  void post_force(int) override;
  void post_run() override;
  /// Of body b, from 9 b on: force [N] and torque about its origin [N m] of the particles on it, power it gives them
  /// [W]; impacts that began since this fix was defined, on all ranks, and the sum of their normal speeds [m/s].
  double compute_vector(int n) override;
  int min_type() override { return type_; }
  int max_type() override { return type_; }
  void grow_arrays(int n) override;
  void copy_arrays(int from, int to, int) override;
  void set_arrays(int particle) override;
  int pack_exchange(int particle, double* buffer) override;
  int unpack_exchange(int particle, double* buffer) override;
  int pack_restart(int particle, double* buffer) override;
  void unpack_restart(int particle, int nth) override;
  int size_restart(int particle) override;
  int maxsize_restart() override;
  void write_restart(FILE* file) override;
  void restart(char* state) override;

 private:
  static constexpr std::size_t kSums = 9;
  class BodyWall;

  void read_materials();
  /// Error: a time step in which a blade passes a particle unseen, or that is too long for the stiffest contact.
  Status check_time_step() const;
  void turn_bodies();
  /// Forces of all bodies on all particles. frozen: nothing is remembered as having moved or begun.
  void push(bool frozen);
  /// Calls done(looks) for all particles that may touch the body, some at a time; found_ has their touches then.
  template <class Done>
  void look_at_due(std::size_t body, Done&& done);
  /// Puts the touches of a look into rows_; pushes those that are there first if there is no room.
  void queue(std::size_t body, const Look& look, bool frozen);
  /// Forces of what is queued, on the particles, on the body, on whoever listens.
  void push_queued(std::size_t body, bool frozen);
  /// Normal speed of the impact in queued touch k, of which we see the overlap that it has made in a part of a step: of
  /// the place where the two first touched [m/s]. Not above 0: they part.
  double impact_speed(std::size_t body, std::size_t k);
  void say_full();
  /// Ends the run if the particle has leapt to the other side of the surface.
  void refuse_if_passed(std::size_t body, const Look& look);
  void forget_looks(int particle);
  /// Adds to the wear of the triangle that queued touch k touches.
  void wear_off(std::size_t body, std::size_t k);
  /// Of all ranks, on rank 0; nothing on the others.
  Wear wear_of_all_ranks(std::size_t body) const;
  void write_wear();

  int type_ = 1;
  RollingModel rolling_ = RollingModel::none;
  bool cohesion_ = false;
  bool pushes_ = true;  ///< false: what it would do is only told
  std::vector<WallBody> bodies_;
  std::vector<Watch> watches_;                     ///< of each body
  std::vector<std::array<double, kSums>> sums_{};  ///< of each body, for compute_vector
  TouchBook book_;
  WearSettings wear_settings_;
  std::vector<Wear> wear_;  ///< of each body, by particles of this rank; empty: none is kept
  long wear_written_ = -1;  ///< step

  // LIGGGHTS' registry writes through the addresses of these.
  double **young_ = nullptr, **shear_ = nullptr, **damping_ = nullptr, **friction_ = nullptr,
         **rolling_friction_ = nullptr, **cohesion_density_ = nullptr;
  std::vector<ContactMaterial> materials_;  ///< of each particle type, from 1 on

  ImpactListener listener_;
  TouchListener touch_listener_;
  static constexpr std::size_t kMostLooks = 64;
  std::array<Look, kMostLooks> looks_;  ///< scratch: some of one body
  std::vector<SurfaceTouch> found_;     ///< scratch: by them
  std::vector<SurfaceTouch> first_;     ///< scratch: where an impact began
  std::vector<std::size_t> slots_;      ///< scratch: of one particle's touches on its page
  TouchHistory unknown_;                ///< of all that have no place on a full page
  struct Queued {
    int particle = 0;
    bool begins = false;
    const SurfaceTouch* touch = nullptr;
    Vector3 *shear = nullptr, *rolling_torque = nullptr;  ///< where they are remembered
  };
  WallRows rows_;                                 ///< scratch: of one body
  std::array<Queued, WallRows::kMost> queued_{};  ///< of each row
  double largest_overlap_ = 0.0;
  bool said_full_ = false;
  long summed_step_ = -1;
  std::vector<double> summed_;  ///< over all ranks, at summed_step_
};

}  // namespace granary::dem
