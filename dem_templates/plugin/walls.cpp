#include "dem_templates/plugin/walls.hpp"

#include <cmath>

#include <atom.h>
#include <fix_contact_history_mesh.h>
#include <fix_mesh_surface.h>
#include <fix_property_atom.h>
#include <fix_wall_gran.h>
#include <lammps.h>
#include <modify.h>
#include <primitive_wall.h>
#include <tri_mesh.h>

#include "dem_templates/plugin/wall/fix_wall.hpp"

namespace granary::dem {
namespace {

using LAMMPS_NS::FixMeshSurface;
using LAMMPS_NS::FixWallGran;

// LIGGGHTS gives the vector from the centre to the nearest point of the wall.
std::array<double, 3> normal_from(const double* to_wall) {
  const double length = std::sqrt(to_wall[0] * to_wall[0] + to_wall[1] * to_wall[1] + to_wall[2] * to_wall[2]);
  if (length == 0.0) return {0.0, 0.0, 0.0};
  return {-to_wall[0] / length, -to_wall[1] / length, -to_wall[2] / length};
}

class MeshWall : public Wall {
 public:
  MeshWall(LAMMPS_NS::LAMMPS& lammps, FixMeshSurface& mesh, int wall_index) : atom_(*lammps.atom), mesh_(mesh) {
    fix_index = wall_index;
  }

  // The contact history holds the triangles each particle touched when the forces were computed.
  void touches(const std::function<void(const WallTouch&)>& found) const override {
    auto& history = *mesh_.contactHistory();
    auto& triangles = *mesh_.triMesh();
    auto* node_velocity = triangles.prop().getElementProperty<LAMMPS_NS::MultiVectorContainer<double, 3, 3>>("v");

    for (int i = 0; i < atom_.nlocal; ++i) {
      double deepest = 0.0;
      WallTouch touch{.particle = i};
      bool touching = false;
      const int n = history.nneighs(i);
      for (int k = 0; k < n; ++k) {
        const int id = history.get_partner_idTri(i, k);
        const int triangle = id < 0 ? -1 : triangles.map(id, 0);
        if (triangle < 0) continue;

        double to_wall[3], barycentric[3];
        int which_feature = -1;
        const double gap = triangles.resolveTriSphereContactBary(i, triangle, atom_.radius[i], atom_.x[i], to_wall,
                                                                 barycentric, which_feature);
        if (gap > deepest || (touching && gap == deepest)) continue;
        deepest = gap;
        touching = true;
        touch.overlap = -gap / atom_.radius[i];
        touch.normal = normal_from(to_wall);
        if (node_velocity) {
          double** v = (*node_velocity)(triangle);
          for (std::size_t d = 0; d < 3; ++d)
            touch.velocity[d] = barycentric[0] * v[0][d] + barycentric[1] * v[1][d] + barycentric[2] * v[2][d];
        }
      }
      if (touching) found(touch);
    }
  }

 private:
  LAMMPS_NS::Atom& atom_;
  FixMeshSurface& mesh_;
};

class PrimitiveBody : public Wall {
 public:
  PrimitiveBody(LAMMPS_NS::LAMMPS& lammps, FixWallGran& wall, int wall_index) : atom_(*lammps.atom), wall_(wall) {
    fix_index = wall_index;
  }

  void touches(const std::function<void(const WallTouch&)>& found) const override {
    int* near = nullptr;
    const int n_near = wall_.primitiveWall()->getNeighbors(near);
    for (int k = 0; k < n_near; ++k) {
      const int i = near[k];
      if (i >= atom_.nlocal) continue;
      double to_wall[3] = {};
      const double gap = wall_.primitiveWall()->resolveContact(atom_.x[i], atom_.radius[i], to_wall);
      if (gap <= 0.0) found({i, -gap / atom_.radius[i], normal_from(to_wall), {}});
    }
  }

 private:
  LAMMPS_NS::Atom& atom_;
  FixWallGran& wall_;
};

template <class Do>
void for_each_wall_fix(LAMMPS_NS::LAMMPS& lammps, Do&& act) {
  for (int i = 0; i < lammps.modify->nfix; ++i)
    if (auto* wall = dynamic_cast<FixWallGran*>(lammps.modify->fix[i])) act(*wall, i);
}

}  // namespace

Result<std::unique_ptr<Wall>> find_mesh_wall(LAMMPS_NS::LAMMPS& lammps, const std::string& mesh_fix) {
  std::unique_ptr<Wall> found;
  bool history = true;
  for_each_wall_fix(lammps, [&](FixWallGran& wall, int index) {
    if (!wall.is_mesh_wall()) return;
    for (int m = 0; m < wall.n_meshes(); ++m) {
      FixMeshSurface& mesh = *wall.mesh_list()[m];
      if (mesh_fix != mesh.id) continue;
      history = mesh.contactHistory() != nullptr;
      found = std::make_unique<MeshWall>(lammps, mesh, index);
    }
  });
  if (!found) return Error{"no wall/gran fix uses a mesh '" + mesh_fix + "'."};
  if (!history)
    return Error{"the wall/gran fix of mesh '" + mesh_fix +
                 "' keeps no contact history: give it 'tangential history'."};
  return found;
}

Result<std::unique_ptr<Wall>> find_primitive_wall(LAMMPS_NS::LAMMPS& lammps, const std::string& wall_fix) {
  std::unique_ptr<Wall> found;
  for_each_wall_fix(lammps, [&](FixWallGran& wall, int index) {
    if (!wall.is_mesh_wall() && wall_fix == wall.id) found = std::make_unique<PrimitiveBody>(lammps, wall, index);
  });
  if (!found) return Error{"there is no primitive wall/gran fix '" + wall_fix + "'."};
  return found;
}

std::vector<std::unique_ptr<Wall>> find_all_walls(LAMMPS_NS::LAMMPS& lammps) {
  std::vector<std::unique_ptr<Wall>> walls;
  for_each_wall_fix(lammps, [&](FixWallGran& wall, int index) {
    if (!wall.is_mesh_wall()) {
      walls.push_back(std::make_unique<PrimitiveBody>(lammps, wall, index));
      return;
    }
    for (int m = 0; m < wall.n_meshes(); ++m)
      if (wall.mesh_list()[m]->contactHistory())
        walls.push_back(std::make_unique<MeshWall>(lammps, *wall.mesh_list()[m], index));
  });
  for (int i = 0; i < lammps.modify->nfix; ++i)
    if (auto* ours = dynamic_cast<FixWall*>(lammps.modify->fix[i]))
      for (const std::string& name : ours->body_names()) walls.push_back(ours->body(name));
  return walls;
}

}  // namespace granary::dem
