// fix ID all granary/tally: counts collisions and impacts that begin, and writes tallies.jsonl. The counting itself is
// plain code in tally/; here it meets LIGGGHTS' particles, neighbour lists and ranks. Syntax: docs/dem_styles.md.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <fix.h>

#include "common/json/io.hpp"
#include "dem_templates/plugin/pair/pair_touching.hpp"
#include "dem_templates/plugin/particle_balance.hpp"
#include "dem_templates/plugin/tally/memory.hpp"
#include "dem_templates/plugin/tally/window.hpp"
#include "dem_templates/plugin/walls.hpp"

namespace granary::dem {

class FixWall;

class FixTally : public LAMMPS_NS::Fix {
 public:
  FixTally(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);
  ~FixTally() override;

  /// granary/outlet is about to take out this particle: note that it crossed the last edge.
  void leaves(int particle);
  // What LIGGGHTS calls.
  int setmask() override;
  void init() override;
  void setup(int) override;
  void post_force(int) override;
  void post_run() override;
  void grow_arrays(int n) override;
  void copy_arrays(int from, int to, int) override;
  void set_arrays(int particle) override;
  int pack_exchange(int particle, double* buffer) override;
  int unpack_exchange(int particle, double* buffer) override;

 private:
  struct Body {
    std::string name, kind, fix;  ///< kind: mesh, wall or of
    std::unique_ptr<Wall> wall;   ///< mesh, wall: looked at
    FixWall* walls = nullptr;     ///< of: tells of its impacts by itself
    std::size_t place = 0;        ///< among the bodies of `walls`
  };
  enum class Purpose { remember, count };

  void look(long step);
  /// Bodies that LIGGGHTS moves: what touches them, and which of that began since the last look.
  void look_at_walls(Purpose purpose);
  void look_at_loads();
  void count_collisions(std::span<const NearPairs::Pair> began);
  void count_impact(std::size_t body, const WallTouch& touch);
  /// Joins a body to its fix. Error: there is none.
  Status find(Body& body);
  void listen();
  /// What there is: particles, speeds, overlaps. Costs more and changes more slowly: at every eighth look.
  void survey(Purpose purpose);

  void close_window();
  /// A line in the log: what the tally took.
  void say_cost() const;
  Status open_file();
  Status write_line(const json::Value& line);

  std::string file_;
  bool goes_on_ = false;  ///< with the file that a run that was cut has left
  long every_ = 5, window_steps_ = 0;
  TallyHeader header_;
  TallyLayout layout_;
  std::vector<Body> bodies_;

  std::optional<Window> window_;
  PairTouching* pairs_ = nullptr;  ///< tells of each contact of two particles as it begins
  std::shared_ptr<PairTouching::Listener> listener_;
  std::vector<Memory> memories_;               ///< of each particle
  std::vector<std::uint64_t> bodies_touched_;  ///< scratch: of each particle, at this look
  std::optional<json::LineWriter> writer_;     ///< on rank 0, from the first run on
  long window_start_ = 0, last_look_ = 0;      ///< steps
  long looks_ = 0;                             ///< since the start of the window
  double window_start_time_ = 0.0;             ///< DEM clock [s]
  double own_seconds_ = 0.0;                   ///< of this run, on this rank
  ParticleBalance balance_;                    ///< at the start of the window
};

}  // namespace granary::dem
