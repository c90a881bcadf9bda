#include "dem_templates/plugin/machine_space.hpp"

#include <mpi.h>

#include <algorithm>
#include <array>

#include <domain.h>
#include <fix_mesh_surface.h>
#include <lammps.h>
#include <modify.h>
#include <region.h>
#include <tri_mesh.h>

#include "dem_templates/plugin/resize/triangles.hpp"
#include "dem_templates/plugin/wall/fix_wall.hpp"

namespace granary::dem {
namespace {

class MachineSpace : public FreeSpace {
 public:
  MachineSpace(LAMMPS_NS::LAMMPS& lammps, LAMMPS_NS::Region& region, Triangles triangles)
      : region_(region),
        triangles_(std::move(triangles)),
        low_{lammps.domain->boxlo[0], lammps.domain->boxlo[1], lammps.domain->boxlo[2]},
        high_{lammps.domain->boxhi[0], lammps.domain->boxhi[1], lammps.domain->boxhi[2]} {
    if (!region.bboxflag) return;
    const Vector3 from{region.extent_xlo, region.extent_ylo, region.extent_zlo},
        to{region.extent_xhi, region.extent_yhi, region.extent_zhi};
    for (std::size_t d = 0; d < 3; ++d) {
      low_[d] = std::max(low_[d], from[d]);
      high_[d] = std::min(high_[d], to[d]);
    }
  }

  bool inside(const Vector3& point) const override { return region_.match(point[0], point[1], point[2]) != 0; }

  void walls_near(const Vector3& point, double reach, std::vector<NearWall>& found) const override {
    const int n = region_.surface(point[0], point[1], point[2], reach);
    for (int c = 0; c < n; ++c) {
      const auto& contact = region_.contact[c];
      const Vector3 away{contact.delx, contact.dely, contact.delz};
      const double distance = norm(away);
      if (distance > 0.0) found.push_back({distance, (1.0 / distance) * away});
    }
    triangles_.near(point, reach, found);
  }

  Vector3 low() const override { return low_; }
  Vector3 high() const override { return high_; }

 private:
  LAMMPS_NS::Region& region_;
  Triangles triangles_;
  Vector3 low_, high_;
};

// LIGGGHTS shares the triangles out among the ranks, or has not done so yet: gather all, drop the doubles, and sort, so
// that every rank has the same list.
std::vector<Triangle> gather_triangles(LAMMPS_NS::LAMMPS& lammps, LAMMPS_NS::TriMesh& mesh) {
  std::vector<double> mine;
  for (int t = 0; t < mesh.sizeLocal(); ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      double point[3];
      mesh.node(t, corner, point);
      mine.insert(mine.end(), point, point + 3);
    }
  }
  int n_ranks = 1;
  MPI_Comm_size(lammps.world, &n_ranks);
  const int n_mine = static_cast<int>(mine.size());
  std::vector<int> sizes(static_cast<std::size_t>(n_ranks)), starts(static_cast<std::size_t>(n_ranks), 0);
  MPI_Allgather(&n_mine, 1, MPI_INT, sizes.data(), 1, MPI_INT, lammps.world);
  for (std::size_t r = 1; r < sizes.size(); ++r) starts[r] = starts[r - 1] + sizes[r - 1];
  std::vector<double> all(static_cast<std::size_t>(starts.back() + sizes.back()));
  MPI_Allgatherv(mine.data(), n_mine, MPI_DOUBLE, all.data(), sizes.data(), starts.data(), MPI_DOUBLE, lammps.world);

  std::vector<Triangle> triangles(all.size() / 9);
  for (std::size_t i = 0; i < all.size(); ++i) triangles[i / 9][i / 3 % 3][i % 3] = all[i];
  std::sort(triangles.begin(), triangles.end());
  triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
  return triangles;
}

}  // namespace

Result<std::unique_ptr<FreeSpace>> machine_space(LAMMPS_NS::LAMMPS& lammps, const std::string& region,
                                                 const std::vector<std::string>& meshes,
                                                 const std::vector<std::string>& walls, double reach) {
  const int index = lammps.domain->find_region(region.c_str());
  if (index < 0) return Error{"there is no region '" + region + "'."};
  std::vector<Triangle> triangles;
  for (const std::string& name : meshes) {
    auto* mesh = dynamic_cast<LAMMPS_NS::FixMeshSurface*>(lammps.modify->find_fix_id(name.c_str()));
    if (!mesh) return Error{"there is no fix mesh/surface '" + name + "'."};
    const auto own = gather_triangles(lammps, *mesh->triMesh());
    triangles.insert(triangles.end(), own.begin(), own.end());
  }
  for (const std::string& name : walls) {
    auto* ours = dynamic_cast<FixWall*>(lammps.modify->find_fix_id(name.c_str()));
    if (!ours) return Error{"there is no fix granary/wall '" + name + "'."};
    for (std::size_t b = 0; b < ours->body_names().size(); ++b) {
      const auto own = ours->triangles(b);
      triangles.insert(triangles.end(), own.begin(), own.end());
    }
  }
  return std::unique_ptr<FreeSpace>(
      std::make_unique<MachineSpace>(lammps, *lammps.domain->regions[index], Triangles(std::move(triangles), reach)));
}

}  // namespace granary::dem
