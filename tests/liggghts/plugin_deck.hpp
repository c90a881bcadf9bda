// Small LIGGGHTS decks for the tests of our styles: written into a folder of their own, run with granary-dem, read
// back.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "common/json/io.hpp"

namespace granary::dem::test {

namespace fs = std::filesystem;

inline const std::string kOneBin = "axis x compartments 1 -1 1 classes 1 0.001 0.01 ";

/// A folder that is gone at the end of the test.
class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "granary-dem-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() { fs::remove_all(path_); }
  fs::path operator/(const std::string& name) const { return path_ / name; }
  const fs::path& path() const { return path_; }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path_ / name) << text; }
  std::string read(const std::string& name) const {
    std::ifstream in(path_ / name);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
  }

 private:
  fs::path path_;
};

inline std::string program() { return std::string(GRANARY_BIN_DIR) + "/granary-dem"; }

inline std::string mpirun(int ranks) {
  return "mpirun --allow-run-as-root --oversubscribe --bind-to none --mca pml ob1 --mca btl self,vader -n " +
         std::to_string(ranks) + " ";
}

/// Runs a shell line in the folder; its exit code. stdout goes to `out`, stderr to `err` there.
inline int shell(const Folder& folder, const std::string& line) {
  const int status = std::system(("cd '" + folder.path().string() + "' && ( " + line + " ) > out 2> err").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Writes the deck and runs it on so many ranks (1: without mpirun); the exit code.
inline int run_deck(const Folder& folder, const std::string& deck, int ranks = 1) {
  folder.write("in.liggghts", deck);
  return shell(folder, (ranks > 1 ? mpirun(ranks) : std::string()) + program() + " -in in.liggghts");
}

/// What every deck begins with; `box` is "xlo xhi ylo yhi zlo zhi", or the name of a restart file.
inline std::string head(const std::string& box, const std::string& boundary = "f f f") {
  return "atom_style granular\natom_modify map array\nboundary " + boundary +
         "\nnewton off\ncommunicate single vel yes\nunits si\n" +
         (box.find(' ') == std::string::npos ? "read_restart " + box + "\n"
                                             : "region box block " + box + " units box\ncreate_box 1 box\n");
}

/// Contacts of restitution e and friction mu, soft enough for a time step of 5e-6 s with particles of some millimetres.
inline std::string physics(double restitution = 0.9, double friction = 0.0, double time_step = 5e-6,
                           double skin = 0.001) {
  std::ostringstream text;
  text << "neighbor " << skin << " bin\nneigh_modify delay 0\n"
       << "fix m1 all property/global youngsModulus peratomtype 5e6\n"
       << "fix m2 all property/global poissonsRatio peratomtype 0.3\n"
       << "fix m3 all property/global coefficientRestitution peratomtypepair 1 " << restitution << "\n"
       << "fix m4 all property/global coefficientFriction peratomtypepair 1 " << friction << "\n"
       << "pair_style gran model hertz tangential history\npair_coeff * *\n"
       << "timestep " << time_step << "\nfix integrate all nve/sphere\n"
       << "thermo 100000\nthermo_modify lost ignore norm no\n";
  return text.str();
}

struct TestParticle {
  double x, y, z, vx, vy, vz, diameter;
};

inline std::string particles(const std::vector<TestParticle>& list) {
  std::ostringstream text;
  text.precision(17);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const TestParticle& p = list[i];
    const std::size_t id = i + 1;
    text << "create_atoms 1 single " << p.x << " " << p.y << " " << p.z << " units box\n"
         << "set atom " << id << " density 1000 diameter " << p.diameter << " vx " << p.vx << " vy " << p.vy << " vz "
         << p.vz << "\n";
  }
  return text.str();
}

inline std::string tally(const std::string& more, int every = 5, int window = 1000) {
  return "fix tally all granary/tally file tallies.jsonl every " + std::to_string(every) + " window " +
         std::to_string(window) + " " + more + "\n";
}

/// tallies.jsonl as read back: what was counted over all windows.
struct Counted {
  std::vector<json::Value> windows;

  explicit Counted(const Folder& folder, const std::string& name = "tallies.jsonl") {
    auto lines = json::read_lines(folder / name);
    EXPECT_TRUE(lines.has_value()) << (lines ? "" : lines.error().message);
    if (!lines) return;
    EXPECT_EQ((*lines)[0].text_or("format", ""), "granary-tallies-1");
    windows.assign(lines->begin() + 1, lines->end());
  }

  /// collisions[p][q], summed.
  std::vector<std::vector<double>> collisions() const {
    std::vector<std::vector<double>> sum;
    for (const json::Value& window : windows) {
      const auto& rows = window["collisions"].items();
      sum.resize(rows.size(), std::vector<double>(rows.size(), 0.0));
      for (std::size_t p = 0; p < rows.size(); ++p)
        for (std::size_t q = 0; q < rows.size(); ++q) sum[p][q] += rows[p].numbers()[q];
    }
    return sum;
  }
  double all_collisions() const {
    double sum = 0.0;
    const auto matrix = collisions();
    for (std::size_t p = 0; p < matrix.size(); ++p)
      for (std::size_t q = p; q < matrix.size(); ++q) sum += matrix[p][q];
    return sum;
  }
  double impacts(const std::string& body) const {
    double sum = 0.0;
    for (const json::Value& window : windows)
      for (double n : window["impacts"].numbers(body)) sum += n;
    return sum;
  }
  double total(const std::string& name) const {
    double sum = 0.0;
    for (const json::Value& window : windows) {
      const json::Value& value = window[name];
      if (value.is_number())
        sum += value.as_number();
      else
        for (double n : value.numbers()) sum += n;
    }
    return sum;
  }
  /// Mean speeds of the windows in which something happened, in order.
  std::vector<double> speeds(const std::string& kind) const {
    std::vector<double> found;
    for (const json::Value& window : windows)
      if (window[kind].number_or("count", 0) > 0) found.push_back(window[kind].number_or("mean", 0));
    return found;
  }
};

}  // namespace granary::dem::test
