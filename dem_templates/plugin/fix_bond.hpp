// fix ID GROUP granary/bond: parallel bonds within agglomerates, their breaking, and the fragments that come of it. The
// law of one bond is bond/bond_law.hpp, fragments are bond/fragment_history.hpp; here both meet LIGGGHTS. Syntax:
// docs/dem_styles.md.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fix.h>

#include "common/json/io.hpp"
#include "common/result.hpp"
#include "dem_templates/plugin/bond/bond_book.hpp"
#include "dem_templates/plugin/bond/bond_rows.hpp"
#include "dem_templates/plugin/bond/bond_settings.hpp"
#include "dem_templates/plugin/bond/fragment_history.hpp"

namespace granary::dem {

class FixWall;

class FixBond : public LAMMPS_NS::Fix {
 public:
  FixBond(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);
  ~FixBond() override;

  /// A particle of this rank becomes part of an agglomerate; its bonds are made when it is time.
  void join(int particle, double agglomerate);
  /// The largest number of an agglomerate so far; all ranks call it.
  double largest_agglomerate() const;

  // What LIGGGHTS calls.
  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void setup(int) override;
  void pre_exchange() override;
  void post_force(int) override;
  void post_run() override;
  /// Bonds there are; bonds that broke; their elastic energy [J]; elastic energy that breaking set free [J]: of all
  /// ranks.
  double compute_vector(int n) override;
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
  int pack_comm(int n, int* list, double* buffer, int pbc_flag, int* pbc) override;
  void unpack_comm(int n, int first, double* buffer) override;
  int pack_reverse_comm(int n, int first, double* buffer) override;
  void unpack_reverse_comm(int n, int* list, double* buffer) override;

 private:
  /// A bond, and where its ends are until the next neighbour list; the row of the same number has its state.
  struct Link {
    int i, j;
    Bond* bond;
  };

  [[noreturn]] void refuse(const std::string& why) const;
  void hear_walls();
  void leave_walls();
  void new_list();
  /// Of the particle with this tag on this rank, or its ghost; -1: not here.
  int place_of(double tag) const;
  void link();
  /// Brings the state of the rows home to the particles' pages, before these move.
  void rows_to_book();
  void drop_lost_partners();
  void share_agglomerates();
  bool make_bonds_if_due();
  void make_bonds();
  Status check_time_step();
  Vector3 between(const Link& link) const;
  void push(bool frozen);
  void break_bond(std::size_t k, double tension);
  /// n numbers of each particle and ghost, to which bonds add; then those of the ghosts are sent home.
  void clear_numbers(std::size_t n);
  void numbers_home();
  double* numbers_of(int particle) { return numbers_.data() + static_cast<std::size_t>(particle) * n_numbers_; }
  void start_telling();
  void number_fragments();
  Tag fragment_of(int particle) const;
  void look_at_pairs();
  void tell_breaks();
  void sample();
  FragmentSurvey survey() const;
  std::vector<std::pair<Tag, Tag>> all_bonds() const;
  bool watching() const { return !settings_.fragments.empty() || !settings_.breaks.empty(); }
  double window_steps() const;

  BondSettings settings_;
  bool grouped_ = false;  ///< `among group` has been done
  BondBook book_;
  std::vector<Link> links_;
  BondRows rows_;
  BondRows::Block block_;
  bool rows_ahead_ = false;                    ///< of the book
  std::vector<double> agglomerate_, waiting_;  ///< of the particles of this rank and its ghosts
  struct ClosePair {
    int i, j;
    double weight;  ///< of the depth
  };
  std::vector<ClosePair> close_pairs_;  ///< of the neighbour list, not of one fragment
  std::vector<Tag> fragment_of_tag_;    ///< lowest tag of the fragment, for each tag; the same on all ranks
  bool fragments_old_ = true;           ///< bonds broke since
  std::vector<double> numbers_;         ///< n_numbers_ of each particle and ghost
  std::size_t n_numbers_ = 0;

  std::vector<BreakEvent> breaks_;                  ///< of this rank, not told yet
  double broken_here_ = 0.0, released_here_ = 0.0;  ///< bonds; [J]
  std::vector<FixWall*> heard_;
  FragmentHistory history_;  ///< on rank 0
  std::optional<json::LineWriter> fragments_, broken_;
  long summed_step_ = -1;
  std::vector<double> summed_;
};

}  // namespace granary::dem
