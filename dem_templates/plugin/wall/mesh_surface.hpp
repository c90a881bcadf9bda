// A surface of triangles.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "dem_templates/plugin/wall/face_cells.hpp"
#include "dem_templates/plugin/wall/surface.hpp"

namespace granary::dem {

/// Triangles, closed or not.
///
/// A touch is a local minimum of the distance from the centre over the surface, that the centre sees. So a shared edge
/// or vertex counts only where no triangle at it comes nearer, a flat seam gives what the whole face would, and
/// neither the far side of a thin blade nor what is buried in another part counts. Touches whose normals differ by less
/// than `smooth` are one, the nearest: a round wall made of small flats pushes once.
class MeshSurface : public Surface {
 public:
  /// At least one triangle, each with an area. smooth: [rad].
  MeshSurface(std::vector<Triangle> triangles, double smooth);
  double touches(const Vector3& centre, double radius, Nearby& nearby, std::vector<SurfaceTouch>& found) override;
  bool between(const Vector3& from, const Vector3& to) const override;
  double farthest_from(const Vector3& origin, const Vector3& unit_axis) const override;
  std::size_t n_parts() const override { return triangles_.size(); }
  std::size_t part_at(const SurfaceTouch& touch) const override;
  std::vector<Triangle> triangles() const override { return triangles_; }

 private:
  /// The plane of a face, and through each of its sides the one that stands on it upright, its normal outwards. As
  /// columns, so that a processor takes all sides at once. Of a triangle the last side is there twice.
  struct alignas(32) Planes {
    double x[4], y[4], z[4];  ///< normals of the sides' planes
    double offset[4];         ///< of these planes along their normals [m]
    Vector3 normal;           ///< of the face
    double height;            ///< of its plane along that [m]

    Vector3 outwards(std::size_t k) const { return {x[k], y[k], z[k]}; }
  };
  /// The same rounded: most faces that are looked at are too far off to touch.
  using Four [[gnu::vector_size(16)]] = float;
  struct alignas(16) Rounded {
    Four x, y, z, offset;
    float normal[3], height;
  };
  /// Heights of a point over them [m].
  struct Heights {
    double over[4];  ///< the sides' planes
    double face;

    /// Distance of the point, in the face's plane, from the farthest side that it is beyond of; not above 0 inside.
    /// No point of the face is nearer.
    double beyond() const { return std::max(std::max(over[0], over[1]), std::max(over[2], over[3])); }
  };
  /// A side as seen from its face: how far it reaches, and how the face that is joined there goes on.
  struct Side {
    double from = 0, to = 0;      ///< of its ends, along it [m]
    double on = 0.0, rise = 0.0;  ///< the way from the side into the other face: along the outwards normal of the
                                  ///< side, along the face's; both 0: nothing is joined
  };
  struct Candidate {
    enum class Kind {
      inside,  ///< nearest point in the inside of the face
      rim,     ///< on a side or a corner
      seam     ///< on a side, and the face that is joined there comes nearer: no touch, but it may hide one
    };
    double distance;
    std::uint32_t face;
    Kind kind;
    Vector3 point;  ///< the nearest; not set for a seam
  };

  /// No point of the face is nearer to p: square of the distance, but for rounding_ in the distance.
  float rough_distance2(std::uint32_t face, const std::array<float, 3>& p) const;
  Heights heights(std::uint32_t face, const Vector3& p) const;
  double height(std::uint32_t face, const Vector3& p) const {
    return dot(planes_[face].normal, p) - planes_[face].height;
  }
  bool contains(std::uint32_t face, const Vector3& p) const;
  void join_sides();
  /// Lists the nearest faces.
  void search(const Vector3& centre, const FaceCells::Near& near, Nearby& nearby) const;
  /// Fills near_ with the faces that touch; returns a distance that the surface keeps from the centre for certain.
  double find_touching(const Vector3& centre, double radius, Nearby& nearby);
  /// A face that lies within the radius, its nearest point not in its inside.
  Candidate on_rim(std::uint32_t face, const Vector3& centre, double radius, const Heights& over) const;
  SurfaceTouch touch(const Vector3& centre, const Candidate& candidate) const;
  bool comes_nearer_elsewhere(const Candidate& candidate) const;
  bool hidden(const Vector3& centre, const SurfaceTouch& behind) const;

  std::vector<Triangle> triangles_;
  std::vector<Face> faces_;
  std::vector<Rounded> rounded_;
  std::vector<Planes> planes_;
  std::vector<std::array<Side, 4>> sides_;
  double same_point_ = 0.0;  ///< points nearer than this are one: the digits of an STL file [m]
  double rounding_ = 0.0;    ///< of a distance worked out in single precision [m]
  double same_direction_;    ///< cosine

  FaceCells cells_;
  double largest_radius_ = 0.0;  ///< that the cells are good for; they are made anew for a larger one [m]

  std::vector<Candidate> near_;  ///< scratch
};

}  // namespace granary::dem
