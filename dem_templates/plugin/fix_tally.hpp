// fix ID all granary/tally: counts collisions and impacts that begin, and writes tallies.jsonl. The counting itself is
// plain code in tally/; here it meets LIGGGHTS' particles, neighbour lists and ranks. Syntax: docs/dem_styles.md.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fix.h>

#include "common/json/io.hpp"
#include "dem_templates/plugin/particle_balance.hpp"
#include "dem_templates/plugin/tally/contact_book.hpp"
#include "dem_templates/plugin/tally/window.hpp"
#include "dem_templates/plugin/walls.hpp"

namespace granary::dem {

class FixTally : public LAMMPS_NS::Fix {
 public:
  FixTally(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);
  ~FixTally() override;

  /// granary/outlet is about to take out this particle: note that it crossed the last edge.
  void leaves(int particle);
  /// The largest overlap seen by this rank since the last call, over the smaller radius.
  double take_largest_overlap();

  // What LIGGGHTS calls.
  int setmask() override;
  void init() override;
  void setup(int) override;
  void post_force(int) override;
  void pre_exchange() override;
  void post_run() override;
  void grow_arrays(int n) override;
  void copy_arrays(int from, int to, int) override;
  void set_arrays(int particle) override;
  int pack_exchange(int particle, double* buffer) override;
  int unpack_exchange(int particle, double* buffer) override;

 private:
  struct Body {
    std::string name, kind, fix;  ///< kind: mesh or wall
    std::unique_ptr<Wall> wall;
  };
  enum class Purpose { remember, count };

  void look(Purpose purpose);
  void look_at_pairs(Purpose purpose);
  void look_at_walls(Purpose purpose);
  void look_at_particles(Purpose purpose);
  void close_window();
  double reach() const;  ///< gap that a pair may close before the next look [m]
  Status open_file();
  Status write_line(const json::Value& line);

  std::string file_;
  long every_ = 5, window_steps_ = 0;
  TallyHeader header_;
  TallyLayout layout_;
  std::vector<Body> bodies_;

  std::optional<Window> window_;
  ContactBook book_;
  std::optional<json::LineWriter> writer_;   ///< on rank 0, from the first run on
  long window_start_ = 0, last_look_ = 0;    ///< steps
  double window_start_time_ = 0.0;           ///< DEM clock [s]
  ParticleBalance balance_;                  ///< at the start of the window
  double largest_overlap_ = 0.0;
};

}  // namespace granary::dem
