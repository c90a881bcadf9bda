// fix ID all granary/tally: counts collisions and impacts that begin, and writes tallies.jsonl. The counting itself is
// plain code in tally/; here it meets LIGGGHTS' particles, neighbour lists and ranks. Syntax: docs/dem_styles.md.
#pragma once

#include <array>
#include <cstdint>
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
  void pre_exchange() override;
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
  /// A pair that has touched since the neighbour list was made.
  struct Contact {
    std::uint64_t slot;  ///< in that list
    bool touching;       ///< at the last look; never if another rank counts it
    int owner, other;    ///< tags of the particles
  };
  /// Two particles, one as the other sees it.
  struct Approach {
    int i, j;           ///< i is of this rank, j may be a ghost
    double d[3], v[3];  ///< place and velocity of i less those of j [m], [m/s]
    double reach;       ///< sum of the radii [m]
    double distance2;   ///< [m^2]
    bool touches() const { return distance2 < reach * reach; }
  };

  /// Which contacts exist, and which of them began since the last look.
  void look(Purpose purpose);
  /// The same for pairs as they were a time ago: 0, or a step if the particles have moved on since the forces [s].
  void look_at_pairs(Purpose purpose, double ago);
  Approach approach(int i, int j, double ago) const;
  /// Counts a pair that is apart now and was apart at the last look, if it touched at a step in between.
  void count_graze(const Approach& now);
  void look_at_walls(Purpose purpose);
  void look_at_loads();
  void count_collision(const Approach& now);
  void count_parted(const Approach& now);
  void count_collision(const Approach& now, double speed);
  void relative_velocity_before(const Approach& now, double* v);
  /// At the last look [m/s]; nullptr: it was not there.
  const double* velocity_before(int particle);
  void count_impact(std::size_t body, const WallTouch& touch);
  /// Joins a body to its fix. Error: there is none.
  Status find(Body& body);
  void listen();
  /// What there is: particles, speeds, overlaps. Costs more and changes more slowly: at every eighth look.
  void survey(Purpose purpose);

  // Contacts belong to one neighbour list; which they are travels with the particles to the next.
  void contacts_to_book();

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
  ContactBook book_;
  std::vector<Contact> contacts_;                      ///< at the last look, by slot
  std::vector<Contact> known_;                         ///< scratch: at the look before
  bool list_is_new_ = true;                            ///< a new neighbour list was made since the last look
  long booked_ = -1;                                   ///< step at which contacts were last written to the book
  int n_local_ = 0;                                    ///< particles of this rank at the last forces
  std::vector<std::array<double, 3>> ghost_velocity_;  ///< at the last look; empty after a new neighbour list
  std::vector<std::uint64_t> bodies_touched_;          ///< scratch: of each particle, at this look
  std::optional<json::LineWriter> writer_;             ///< on rank 0, from the first run on
  long window_start_ = 0, last_look_ = 0;              ///< steps
  long looks_ = 0;                                     ///< since the start of the window
  double window_start_time_ = 0.0;                     ///< DEM clock [s]
  double own_seconds_ = 0.0;                           ///< of this run, on this rank
  ParticleBalance balance_;                            ///< at the start of the window
};

}  // namespace granary::dem
