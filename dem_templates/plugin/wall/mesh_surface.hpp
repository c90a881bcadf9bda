// A surface of triangles.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
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
  void look(std::span<Look> looks, std::vector<SurfaceTouch>& found) override;
  bool between(const Vector3& from, const Vector3& to) const override;
  double farthest_from(const Vector3& origin, const Vector3& unit_axis) const override;
  std::size_t n_parts() const override { return triangles_.size(); }
  std::size_t part_at(const SurfaceTouch& touch) const override;
  std::vector<Triangle> triangles() const override { return triangles_; }

 private:
  using Four [[gnu::vector_size(32)]] = double;
  /// The plane of a face, and through each of its sides the one that stands on it upright, its normal outwards. As
  /// columns, so that a processor takes all sides at once. Of a triangle the last side is there twice.
  struct Planes {
    Four x, y, z;    ///< normals of the sides' planes
    Four offset;     ///< of these planes along their normals [m]
    Vector3 normal;  ///< of the face
    double height;   ///< of its plane along that [m]

    Vector3 outwards(std::size_t k) const { return {x[k], y[k], z[k]}; }
  };
  /// How far a point is from a face.
  struct Measured {
    double height;     ///< over the face's plane [m]
    double beyond;     ///< Heights::beyond() [m]
    double distance2;  ///< square of a distance that the face keeps at least [m^2]
  };
  /// Heights of a point over them [m].
  struct Heights {
    Four over;  ///< the sides' planes
    double face;

    /// Distance of the point, in the face's plane, from the farthest side that it is beyond of; not above 0 inside.
    /// No point of the face is nearer.
    double beyond() const { return std::max(std::max(over[0], over[1]), std::max(over[2], over[3])); }
    /// Without a branch: on which side of a side a point is cannot be foreseen.
    Measured measured() const {
      const double out = beyond(), outside = 0.5 * (out + std::abs(out));
      return {face, out, face * face + outside * outside};
    }
  };
  /// A side as seen from its face: how far it reaches, and how the face that is joined there goes on.
  struct Side {
    double from = 0, to = 0;      ///< of its ends, along it [m]
    double on = 0.0, rise = 0.0;  ///< the way from the side into the other face: along the outwards normal of the
                                  ///< side, along the face's; both 0: nothing is joined
  };
  /// A face that may be near enough to a sphere.
  struct Pair {
    std::uint32_t look, face;
  };
  /// Equal distances by number: how they were found must not show.
  static bool is_before(double distance, std::uint32_t face, double other_distance, std::uint32_t other_face) {
    return (distance < other_distance) | ((distance == other_distance) & (face < other_face));
  }
  /// A face that a sphere reaches.
  struct Candidate {
    enum class Kind : std::uint32_t {
      inside,  ///< nearest point in the inside of the face
      rim,     ///< on a side or a corner
      seam     ///< on a side, and the face that is joined there comes nearer: no touch, but it may hide one
    };
    double distance;
    std::uint32_t face;
    Kind kind;
    double height;  ///< of the centre over the face's plane [m]
    Vector3 point;  ///< the nearest; set for a rim

    bool before(const Candidate& other) const { return is_before(distance, face, other.distance, other.face); }
  };

  static Heights heights(const Planes& planes, const Vector3& p);
  Heights heights(std::uint32_t face, const Vector3& p) const { return heights(planes_[face], p); }
  double height(std::uint32_t face, const Vector3& p) const {
    return dot(planes_[face].normal, p) - planes_[face].height;
  }
  static void measure(const Planes* planes, const Look* looks, const Pair* pairs, std::size_t n, Measured* measured);
  bool contains(std::uint32_t face, const Vector3& p) const;
  void join_sides();
  /// Lists the nearest faces.
  void search(const Vector3& centre, const FaceCells::Near& near, Nearby& nearby) const;
  /// The way from the place where its faces were listed, at most [m].
  double moved(const Look& look) const;
  /// Lists the nearest faces of those that have moved too far from where it was done before.
  void search_again(std::span<Look> looks);
  /// For so many pairs.
  void grow(std::size_t n_pairs);
  /// Adds the faces that may touch to pairs_, and sets `clear` to what all others keep.
  void find_pairs(Look& look, std::uint32_t number);
  /// Adds the touches of a sphere to `found`, of the faces in reached_. False if it reaches none of them after all;
  /// else look.clear is the distance of the nearest.
  bool touches(Look& look, std::vector<SurfaceTouch>& found);
  /// The same of two, each reached in its inside. False, and nothing is done, if one may hide the other.
  bool touches_two_insides(Look& look, std::vector<SurfaceTouch>& found) const;
  /// A face that lies within the radius, its nearest point not in its inside.
  void find_on_rim(const Vector3& centre, double radius, Candidate& found) const;
  void set_inside(const Vector3& centre, std::uint32_t face, double height, SurfaceTouch& touch) const;
  void set_touch(const Vector3& centre, const Candidate& candidate, SurfaceTouch& touch) const;
  bool comes_nearer_elsewhere(const Candidate& candidate) const;
  bool hidden(const Vector3& centre, const SurfaceTouch& behind) const;

  std::vector<Triangle> triangles_;
  std::vector<Face> faces_;
  std::vector<Planes> planes_;
  std::vector<std::array<Side, 4>> sides_;
  double same_point_ = 0.0;  ///< points nearer than this are one: the digits of an STL file [m]
  double rounding_ = 0.0;    ///< of what is kept in single precision [m]
  double same_direction_;    ///< cosine

  FaceCells cells_;
  double largest_radius_ = 0.0;  ///< that the cells are good for; they are made anew for a larger one [m]

  // Scratch.
  std::vector<double> moved_;              ///< of each look
  std::vector<std::uint32_t> lost_;        ///< looks without a list
  std::vector<FaceCells::Near> searched_;  ///< of each
  std::vector<Pair> pairs_;
  std::size_t n_pairs_ = 0;
  std::vector<Measured> measured_;      ///< of each pair
  std::vector<std::uint32_t> reached_;  ///< pairs of one sphere that are nearer than its radius
  std::size_t n_reached_ = 0;
  std::vector<Candidate> candidates_;   ///< of one sphere
  std::vector<const Candidate*> near_;  ///< those it reaches, the nearest first
};

}  // namespace granary::dem
