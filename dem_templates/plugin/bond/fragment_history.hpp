// What the breaking bonds make of the agglomerates, as lines of fragments.jsonl and breaks.jsonl (docs/dem_styles.md).
// Lives on rank 0; all ranks' particles, bonds and breaks are handed to it. Knows no LIGGGHTS.
#pragma once

#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/json/value.hpp"
#include "dem_templates/plugin/bond/bond_book.hpp"
#include "dem_templates/plugin/bond/bond_graph.hpp"
#include "dem_templates/plugin/bond/fragment_sizes.hpp"

namespace granary::dem {

/// All particles of agglomerates and the bonds between them, at one step.
struct FragmentSurvey {
  struct Particle {
    Tag tag = 0, agglomerate = 0;
    FragmentParticle shape;
  };
  std::vector<Particle> particles;
  std::vector<std::pair<Tag, Tag>> bonds;
  Vector3 period{};  ///< of the box, 0 where it does not repeat [m]
};

/// A bond that broke.
struct BreakEvent {
  double step = 0.0, time = 0.0;  ///< time [s]
  Tag agglomerate = 0, tag = 0, far_tag = 0;
  Vector3 place{};  ///< [m]
  BreakMode mode = BreakMode::tension;
  double stress = 0.0;  ///< [Pa]
};

class FragmentHistory {
 public:
  /// Names of what may lean on a particle, by Squeeze::cause; steps within which it can be the cause of a break.
  void set_causes(std::vector<std::string> names, double window_steps);

  /// Begins, or goes on, from what there is.
  void start(const FragmentSurvey& survey);
  /// A line for each bond that broke since the last call. The cause is what squeezed a particle of that fragment
  /// deepest within the window before. What a blow sets off goes on when the particles it struck have come off: a
  /// fragment that nothing squeezes has the cause of the last break of the piece it was part of, if that lies in the
  /// window. Then comes debris of the same agglomerate; "none" if nothing did.
  std::vector<json::Value> break_lines(std::vector<BreakEvent> events,
                                       const std::unordered_map<Tag, Squeeze>& squeezes);
  /// The line of a sample; splits are since the last one.
  json::Value sample_line(double time, double step, const FragmentSurvey& survey);
  double last_sample() const { return last_sample_; }  ///< step; -1: there was none

  /// For the restart file.
  std::vector<double> state() const;
  void set_state(const double* values);

 private:
  void set_graph(const FragmentSurvey& survey);
  /// Place among the names; -1: none.
  int cause_of(const BreakEvent& event, const std::vector<Tag>& fragment,
               const std::unordered_map<Tag, Squeeze>& squeezes);
  int cause_of(const Split& split) const;
  std::string name_of(int cause) const { return cause < 0 ? "none" : names_[static_cast<std::size_t>(cause)]; }

  std::vector<std::string> names_;
  double window_ = 0.0;
  BondGraph graph_;
  double broken_ = 0.0, last_sample_ = -1.0;
  std::set<Tag> agglomerates_, broken_agglomerates_;
  std::vector<std::vector<Tag>> fragments_;        ///< of the last sample
  std::vector<std::pair<Tag, int>> causes_since_;  ///< of each break since then, by one end of the bond
  struct Blow {
    int cause;
    double step;
  };
  std::unordered_map<Tag, Blow> blows_;  ///< the last to the piece each particle was part of
};

}  // namespace granary::dem
