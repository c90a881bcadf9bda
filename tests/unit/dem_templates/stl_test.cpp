#include "dem_templates/geometry/stl.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

#include "dem_templates/geometry/solids.hpp"

namespace granary::dem {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class Stl : public testing::Test {
 protected:
  Stl() : folder_(fs::temp_directory_path() / ("granary_stl_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~Stl() override { fs::remove_all(folder_); }

  fs::path file(const std::string& bytes) const {
    std::ofstream(folder_ / "wall.stl", std::ios::binary) << bytes;
    return folder_ / "wall.stl";
  }
  static Mesh shaft() {
    return body_of_revolution(Axis::z, {{0.0, 0.0}, {0.0, 0.0123456789}, {0.1, 0.0123456789}, {0.1, 0.0}}, 7);
  }
  static std::string binary(const Mesh& mesh) {
    std::string bytes(80, ' ');
    bytes.replace(0, 5, "solid");  // as many exporters do
    const auto put = [&](const void* data, std::size_t n) { bytes.append(static_cast<const char*>(data), n); };
    const auto count = static_cast<std::uint32_t>(mesh.triangle.size());
    put(&count, 4);
    for (const Corners& t : mesh.triangle) {
      float numbers[12] = {0, 0, 0};
      for (int k = 0; k < 3; ++k) {
        const Vec3 p = mesh.vertex[t[k]];
        numbers[3 + 3 * k] = static_cast<float>(p.x);
        numbers[4 + 3 * k] = static_cast<float>(p.y);
        numbers[5 + 3 * k] = static_cast<float>(p.z);
      }
      put(numbers, sizeof numbers);
      put("\0\0", 2);
    }
    return bytes;
  }
  std::string refused(const std::string& bytes) const {
    const auto mesh = read_stl(file(bytes));
    return mesh ? "read" : mesh.error().message;
  }

  fs::path folder_;
};

TEST_F(Stl, ReadsBackWhatItWrote) {
  const auto mesh = read_stl(file(stl_text(shaft(), "shaft")));

  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ(mesh->triangle.size(), shaft().triangle.size());
  EXPECT_EQ(mesh->vertex.size(), shaft().vertex.size());
  EXPECT_NEAR(volume(*mesh), volume(shaft()), 1e-10 * volume(shaft()));
}

TEST_F(Stl, ReadsBinaryFilesThatBeginWithSolid) {
  const auto mesh = read_stl(file(binary(shaft())));

  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ(mesh->vertex.size(), shaft().vertex.size());
  EXPECT_NEAR(volume(*mesh), volume(shaft()), 1e-5 * volume(shaft()));
}

TEST_F(Stl, NamesTheFileAndWhatIsWrongWithIt) {
  Mesh holed = shaft();
  holed.triangle.pop_back();
  const std::string whole = stl_text(shaft(), "shaft");

  const auto missing = read_stl(folder_ / "nothing.stl");
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message, AllOf(HasSubstr("nothing.stl"), HasSubstr("no such file")));
  EXPECT_EQ(missing.error().exit, Exit::bad_input);
  EXPECT_THAT(refused("<html>not found</html>"), AllOf(HasSubstr("wall.stl"), HasSubstr("not an STL file")));
  EXPECT_THAT(refused(""), HasSubstr("not an STL file"));
  EXPECT_THAT(refused("solid empty\nendsolid empty\n"), HasSubstr("has no triangles"));
  EXPECT_THAT(refused(whole.substr(0, whole.size() / 2)), AllOf(HasSubstr("was cut"), HasSubstr("line")));
  EXPECT_THAT(refused(binary(shaft()).substr(0, 400)), testing::Not("read"));
  EXPECT_THAT(refused(stl_text(holed, "holed")), AllOf(HasSubstr("not watertight"), HasSubstr("the edge from (")));
  EXPECT_THAT(refused("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 zero\n"), HasSubstr("line 4"));
}

}  // namespace
}  // namespace granary::dem
