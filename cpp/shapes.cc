// Collision shapes. Bodies and compounds share them; a shape in use can't be removed.
#include <algorithm>

#include "state.h"
#include "world.h"

namespace itarl {

namespace {

// A hull's support function visits every point, several times a contact and step.
constexpr std::size_t kMostHullPoints = 1024;
constexpr std::size_t kMostChildren = 256;
// btOptimizedBvh keeps 21 bits for a triangle's index.
constexpr std::size_t kMostTriangles = (1 << 21) - 1;

// Bullet's hull reads the point before its first if none lies farther than -1e18 along a direction,
// as along NaN: the normal of a mesh's triangle that rounds to a point or a line in the world. Here
// it takes the first point then, as convexHullSupport in Bullet's btConvexShape.cpp does.
class Hull final : public btConvexHullShape {
 public:
  btVector3 localGetSupportingVertexWithoutMargin(const btVector3& direction) const override {
    // Times any point's 1e6 m this stays far above -1e18; false for NaN.
    const btScalar farthest = btScalar(1e9);
    const bool usable = btFabs(direction.x()) <= farthest && btFabs(direction.y()) <= farthest &&
                        btFabs(direction.z()) <= farthest;
    return usable ? btConvexHullShape::localGetSupportingVertexWithoutMargin(direction)
                  : getScaledPoint(0);
  }
};

// Bullet has no ellipsoid: its spheres can't be stretched, and of several as one the farthest point
// is wrong once they are. Here it's exact: along d that of x^2/a^2 + y^2/b^2 + z^2/c^2 = 1 is a^2 d
// over |a d|, with the radii a.
class Ellipsoid final : public btConvexInternalShape {
 public:
  explicit Ellipsoid(const btVector3& radii) : radii_(radii) {
    m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
    setMargin(0);
  }
  const char* getName() const override { return "Ellipsoid"; }
  btVector3 localGetSupportingVertexWithoutMargin(const btVector3& direction) const override {
    const btVector3 stretched = radii_ * direction;
    const btScalar length = stretched.length();
    // False for NaN, too.
    if (!(length > 0)) return btVector3(radii_.x(), 0, 0);
    return radii_ * (stretched / length);
  }
  btVector3 localGetSupportingVertex(const btVector3& direction) const override {
    return localGetSupportingVertexWithoutMargin(direction);
  }
  void batchedUnitVectorGetSupportingVertexWithoutMargin(const btVector3* directions,
                                                         btVector3* points,
                                                         int count) const override {
    for (int i = 0; i < count; ++i) {
      points[i] = localGetSupportingVertexWithoutMargin(directions[i]);
    }
  }
  void calculateLocalInertia(btScalar mass, btVector3& inertia) const override {
    const btVector3 squares = radii_ * radii_ * (mass / 5);
    inertia.setValue(squares.y() + squares.z(), squares.x() + squares.z(),
                     squares.x() + squares.y());
  }

 private:
  btVector3 radii_;
};

ShapeId keep(State& state, ShapeEntry entry) {
  state.shapes.push_back(std::make_unique<ShapeEntry>(std::move(entry)));
  return ShapeId{static_cast<std::uint32_t>(state.shapes.size() - 1)};
}

std::unique_ptr<btCollisionShape> make_primitive(const Call& call, const PrimitiveSpec& spec) {
  const auto& size = spec.size;
  const auto round = [&](const char* kind) {
    const std::string name(kind);
    const btScalar radius = call.size(name + ".radius", size[0]);
    return std::pair(radius, call.size(name + ".length", size[1]));
  };
  switch (spec.kind) {
    case Primitive::Plane: {
      btVector3 normal = call.numbers("plane.normal", {size[0], size[1], size[2]});
      const btScalar offset = call.coordinate("plane.offset", size[3]);
      const double square = size[0] * size[0] + size[1] * size[1] + size[2] * size[2];
      if (!(std::abs(square - 1) < 1e-5)) {
        call.refuse("plane.normal", "a unit vector", "one of squared length " + to_text(square));
      }
      return std::make_unique<btStaticPlaneShape>(normal, offset);
    }
    case Primitive::Box:
      return std::make_unique<btBoxShape>(
          call.sizes("box.half_extents", {size[0], size[1], size[2]}));
    case Primitive::Sphere:
      return std::make_unique<btSphereShape>(call.size("sphere.radius", size[0]));
    case Primitive::Ellipsoid:
      return std::make_unique<Ellipsoid>(call.sizes("ellipsoid.radii", {size[0], size[1], size[2]}));
    case Primitive::Capsule: {
      const auto [radius, length] = round("capsule");
      if (spec.axis == 0) return std::make_unique<btCapsuleShapeX>(radius, length);
      if (spec.axis == 1) return std::make_unique<btCapsuleShape>(radius, length);
      return std::make_unique<btCapsuleShapeZ>(radius, length);
    }
    case Primitive::Cylinder: {
      const auto [radius, length] = round("cylinder");
      btVector3 half(radius, radius, radius);
      half[spec.axis] = length / 2;
      if (spec.axis == 0) return std::make_unique<btCylinderShapeX>(half);
      if (spec.axis == 1) return std::make_unique<btCylinderShape>(half);
      return std::make_unique<btCylinderShapeZ>(half);
    }
  }
  call.refuse("kind", "a primitive shape", std::to_string(int(spec.kind)));
}

std::vector<btVector3> to_points(const Call& call, std::string_view argument,
                                 rust::Slice<const double> numbers) {
  std::vector<btVector3> points(numbers.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = call.point(std::string(argument) + "[" + std::to_string(i) + "]",
                           {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]});
  }
  return points;
}

// Whether the points span a volume: the farthest from the first, then from that line, then from
// that plane, must each lie away from it.
bool span_volume(const std::vector<btVector3>& points) {
  const auto farthest = [&](auto distance) {
    return *std::max_element(points.begin(), points.end(), [&](const auto& p, const auto& q) {
      return distance(p) < distance(q);
    });
  };
  const btVector3 origin = points.front();
  const btVector3 a = farthest([&](const btVector3& p) { return (p - origin).length2(); }) - origin;
  const btScalar length = a.length();
  if (!(length >= kShortestLength)) return false;
  const btVector3 b =
      farthest([&](const btVector3& p) { return a.cross(p - origin).length2(); }) - origin;
  const btVector3 normal = a.cross(b);
  // A thousandth of a degree: thinner hulls are flat to single precision.
  const btScalar thinnest = btScalar(2e-5);
  if (!(normal.length() >= thinnest * length * length)) return false;
  const btVector3 c =
      farthest([&](const btVector3& p) { return btFabs(normal.dot(p - origin)); }) - origin;
  return btFabs(normal.dot(c)) >= thinnest * length * normal.length();
}

}  // namespace

ShapeId World::add_primitive(const PrimitiveSpec& spec) {
  ShapeEntry entry;
  entry.shape = make_primitive(Call{"add_shape"}, spec);
  entry.solid = spec.kind != Primitive::Plane;
  return keep(*state_, std::move(entry));
}

ShapeId World::add_hull(rust::Slice<const double> points, double margin) {
  const Call call{"add_shape"};
  const std::size_t count = points.size() / 3;
  if (count < 4 || count > kMostHullPoints) {
    call.refuse("hull.points", "4 to " + std::to_string(kMostHullPoints) + " points",
                std::to_string(count));
  }
  const btScalar checked_margin =
      call.within("hull.margin", margin, 0, kLongestLength, "between 0 and 1e6 m");
  const std::vector<btVector3> corners = to_points(call, "hull.points", points);
  if (!span_volume(corners)) {
    call.refuse("hull.points", "points that span a volume",
                std::to_string(count) + " points in a plane");
  }
  auto hull = std::make_unique<Hull>();
  for (const btVector3& corner : corners) hull->addPoint(corner, false);
  hull->setMargin(checked_margin);
  hull->recalcLocalAabb();
  ShapeEntry entry;
  entry.shape = std::move(hull);
  return keep(*state_, std::move(entry));
}

ShapeId World::add_compound(rust::Slice<const CompoundChild> children) {
  const Call call{"add_shape"};
  if (children.empty() || children.size() > kMostChildren) {
    call.refuse("compound.children", "1 to " + std::to_string(kMostChildren) + " shapes",
                std::to_string(children.size()));
  }
  // Without the tree of children: contacts then come in the order of the children, and there is
  // no tree to save in a snapshot.
  auto compound = std::make_unique<btCompoundShape>(false, int(children.size()));
  ShapeEntry entry;
  for (std::size_t i = 0; i < children.size(); ++i) {
    const std::string name = "compound.children[" + std::to_string(i) + "]";
    const ShapeEntry& child = state_->shape(call, name, children[i].shape);
    if (!child.solid || !child.children.empty()) {
      call.refuse(name, "a box, sphere, capsule, cylinder, ellipsoid or hull",
                  child.shape->getName() + std::string(" (shape ") +
                      std::to_string(children[i].shape.slot) + ")");
    }
    compound->addChildShape(to_transform(call, name + ".pose", children[i].pose),
                            child.shape.get());
    entry.children.push_back(children[i].shape.slot);
  }
  entry.shape = std::move(compound);
  const ShapeId id = keep(*state_, std::move(entry));
  for (std::uint32_t slot : state_->shapes[id.slot]->children) ++state_->shapes[slot]->users;
  return id;
}

ShapeId World::add_mesh(rust::Slice<const double> vertices,
                        rust::Slice<const std::uint32_t> triangles) {
  const Call call{"add_shape"};
  const std::size_t vertex_count = vertices.size() / 3;
  const std::size_t triangle_count = triangles.size() / 3;
  if (triangle_count < 1 || triangle_count > kMostTriangles) {
    call.refuse("mesh.triangles", "1 to " + std::to_string(kMostTriangles) + " triangles",
                std::to_string(triangle_count));
  }
  if (vertex_count < 3 || vertex_count > 3 * kMostTriangles) {
    call.refuse("mesh.vertices", "3 to " + std::to_string(3 * kMostTriangles) + " points",
                std::to_string(vertex_count));
  }
  auto mesh = std::make_unique<MeshData>();
  const std::vector<btVector3> corners = to_points(call, "mesh.vertices", vertices);
  for (const btVector3& corner : corners) {
    mesh->vertices.insert(mesh->vertices.end(), {corner.x(), corner.y(), corner.z()});
  }
  for (std::size_t i = 0; i < triangle_count; ++i) {
    const std::string name = "mesh.triangles[" + std::to_string(i) + "]";
    std::array<btVector3, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t index = triangles[3 * i + k];
      if (index >= vertex_count) {
        call.refuse(name, "indices below " + std::to_string(vertex_count), std::to_string(index));
      }
      mesh->indices.push_back(static_cast<int>(index));
      corner[k] = corners[index];
    }
    // Bullet divides by the length of this normal, and a NaN would swallow the contact.
    const btVector3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    if (!(normal.length2() > 0)) {
      call.refuse(name, "a triangle with an area", "three corners in a line");
    }
  }
  btIndexedMesh part;
  part.m_numTriangles = static_cast<int>(triangle_count);
  part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(mesh->indices.data());
  part.m_triangleIndexStride = 3 * sizeof(int);
  part.m_numVertices = static_cast<int>(vertex_count);
  part.m_vertexBase = reinterpret_cast<const unsigned char*>(mesh->vertices.data());
  part.m_vertexStride = 3 * sizeof(btScalar);
  part.m_vertexType = sizeof(btScalar) == 8 ? PHY_DOUBLE : PHY_FLOAT;
  mesh->view.addIndexedMesh(part, PHY_INTEGER);

  ShapeEntry entry;
  entry.shape = std::make_unique<btBvhTriangleMeshShape>(&mesh->view, true);
  entry.mesh = std::move(mesh);
  entry.solid = false;
  return keep(*state_, std::move(entry));
}

void World::remove_shape(ShapeId id) {
  const Call call{"remove_shape"};
  const ShapeEntry& entry = state_->shape(call, "id", id);
  if (entry.users > 0) {
    call.refuse("id", "a shape that nothing uses",
                "shape " + std::to_string(id.slot) + ", used by " + std::to_string(entry.users) +
                    " bodies or compounds");
  }
  for (std::uint32_t slot : entry.children) --state_->shapes[slot]->users;
  state_->shapes[id.slot].reset();
}

}  // namespace itarl
