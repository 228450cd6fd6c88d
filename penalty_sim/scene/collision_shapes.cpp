#include "scene/collision_shapes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "haptic_core/geometry/hulls/ground.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/cone.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "scene/height_file.h"
#include "scene/mesh_file.h"
#include "scene/resource_path.h"

namespace haptic {
namespace {

/// Facets of what a scene asks to be a polyhedron, where it names the other number only: the surface error is 0.5 % of
/// the radius for a cylinder and about 3 % for a capsule's ends; finer ones cost contact time in proportion to the
/// facets in touch.
constexpr int kSegments = 32;
constexpr int kSubdivision = 2;

struct Refinement {
  int segments = kSegments, subdivision = kSubdivision;
  bool prism = false, faceted = false;  ///< segments, a subdivision is given
  double surface_error = 0;             ///< of a mesh [m]; 0: as usual
  std::string type;                     ///< of what collides in place of the geometry; empty: the geometry
};

/// Types of <haptic:shape>, and the attributes that each has.
const std::map<std::string, std::vector<const char*>> kTypes = {
    {"half_space", {}},
    {"ellipsoid", {"radii"}},
    {"cone", {"radius", "top_radius", "length"}},
    {"height_field", {"file", "heights", "size", "thickness"}},
    {"ground", {"thickness"}}};

/// Names of types that have the attribute, as they are written.
std::string typesWith(const std::string& attribute) {
  std::string names;
  for (const auto& [name, attributes] : kTypes) {
    for (const char* each : attributes) {
      if (each == attribute) names += (names.empty() ? "type=\"" : "\" or \"") + name;
    }
  }
  return names + "\"";
}

void refuseAttributesOfOthers(const XmlFile& file, const XmlElement& shape, const std::string& type) {
  const auto own = kTypes.find(type);
  for (const auto& [name, attributes] : kTypes) {
    for (const std::string attribute : attributes) {
      const bool has = own != kTypes.end() && std::find(own->second.begin(), own->second.end(), attribute) != own->second.end();
      if (has || !shape.Attribute(attribute.c_str())) continue;
      throw SetupError(file.at(shape) + ": <haptic:shape>", "has " + attribute + " but is no " + name,
                       "write " + typesWith(attribute) + ", or leave " + attribute + " out");
    }
  }
}

Refinement readRefinement(const XmlFile& file, const XmlElement& collision) {
  Refinement refinement;
  const XmlElement* shape = collision.FirstChildElement("haptic:shape");
  if (!shape) return refinement;
  refuseUnknownAttributes(file, *shape, {"segments", "subdivision", "type", "radii", "radius", "top_radius", "length", "file", "heights",
                                         "size", "thickness", "surface_error"});
  if (const char* type = shape->Attribute("type")) {
    if (kTypes.count(type) == 0) {
      throw SetupError(file.at(*shape) + ": <haptic:shape>", "type '" + std::string(type) + "' is unknown",
                       "write type=\"half_space\", \"ellipsoid\", \"cone\", \"height_field\", \"ground\", or none");
    }
    refinement.type = type;
  }
  refuseAttributesOfOthers(file, *shape, refinement.type);
  const double segments = readNumber(file, *shape, "segments").value_or(kSegments);
  const double subdivision = readNumber(file, *shape, "subdivision").value_or(kSubdivision);
  if (segments != std::floor(segments) || segments < 3 || segments > 256) {
    throw SetupError(file.at(*shape) + ": <haptic:shape>", "segments is no whole number of 3…256",
                     "write e.g. 64");
  }
  if (subdivision != std::floor(subdivision) || subdivision < 0 || subdivision > 5) {
    throw SetupError(file.at(*shape) + ": <haptic:shape>", "subdivision is no whole number of 0…5",
                     "write e.g. 3");
  }
  if (const auto error = readNumber(file, *shape, "surface_error")) {
    if (!(*error > 0)) throw SetupError(file.at(*shape) + ": <haptic:shape>", "surface_error is not > 0", "write metres, e.g. 0.001");
    refinement.surface_error = *error;
  }
  refinement.segments = static_cast<int>(segments);
  refinement.subdivision = static_cast<int>(subdivision);
  refinement.prism = shape->Attribute("segments") != nullptr;
  refinement.faceted = shape->Attribute("subdivision") != nullptr;
  return refinement;
}

double positive(const XmlFile& file, const XmlElement& shape, const char* attribute,
                const std::string& where) {
  const auto value = readNumber(file, shape, attribute);
  if (!value)
    throw SetupError(where, std::string("<") + shape.Name() + "> has no " + attribute, "give it in metres");
  if (*value <= 0) {
    throw SetupError(where,
                     std::string("<") + shape.Name() + "> has " + attribute + " " + std::to_string(*value),
                     "write a size > 0 in metres");
  }
  return *value;
}

std::string tessellationText(const TessellationReport& report, int vertices) {
  std::ostringstream text;
  text << vertices << " vertices, surface within " << report.surface_error * 1e3 << " mm, volume "
       << report.volume_error * 100 << " % small";
  return text.str();
}

using Shape = std::shared_ptr<const ConvexShape>;
using Polyhedron = std::shared_ptr<const ConvexPolyhedron>;

/// Hull of two tessellated spheres: exact where the spheres' vertices are.
ConvexPolyhedron makeCapsule(double radius, double length, int subdivision, const std::string& name,
                             TessellationReport* report) {
  const ConvexPolyhedron sphere = makeSphere(radius, subdivision, RoundFit::kInscribed, name, report);
  std::vector<Vector3> points;
  for (const Vector3& v : sphere.vertices()) {
    if (v.z() > -1e-9 * radius) points.push_back(v + Vector3(0, 0, 0.5 * length));
    if (v.z() < 1e-9 * radius) points.push_back(v - Vector3(0, 0, 0.5 * length));
  }
  return ConvexPolyhedron::hull(points, name);
}

/// Half-space, ellipsoid or cone of <haptic:shape>; `made` holds the geometry beside it.
void takeType(const XmlFile& file, const XmlElement& shape, const std::string& type, const std::string& where, ShapePieces& made) {
  const std::string elsewhere = " (elsewhere: " + made.text + ")";
  std::ostringstream text;
  if (type == "half_space") {
    made.pieces = {std::make_shared<HalfSpace>(where)};
    made.text = "half-space, all below z = 0 of the collision's frame" + elsewhere;
    made.fixed_only = "a half-space, which has no end";
    return;
  }
  if (type == "ellipsoid") {
    const auto radii = readVector(file, shape, "radii");
    if (!radii) throw SetupError(where, "<haptic:shape> of an ellipsoid has no radii", "give radii=\"x y z\" in metres");
    made.pieces = {std::make_shared<Ellipsoid>(*radii, where)};
    text << "ellipsoid r " << radii->x() << " × " << radii->y() << " × " << radii->z() << " m, exact on planes and polyhedra, elsewhere";
  } else {
    const double radius = positive(file, shape, "radius", where), length = positive(file, shape, "length", where);
    const double top = readNumber(file, shape, "top_radius").value_or(0);
    made.pieces = {std::make_shared<Cone>(radius, top, length, where)};
    text << "cone r " << radius << " to " << top << " l " << length << " m, in contacts";
  }
  const ConvexShape& made_shape = *made.pieces[0];
  text << " a polyhedron of " << made_shape.tessellation()->vertexCount() << " vertices, surface within "
       << made_shape.tessellationError() * 1e3 << " mm";
  made.text = text.str() + elsewhere;
  measure(made);
}

/// The surface of <haptic:shape type="height_field">.
HeightGrid heightsOf(const RobotFile& robot, const std::string& where, const XmlElement& shape) {
  const char *uri = shape.Attribute("file"), *text = shape.Attribute("heights");
  if (!uri == !text) throw SetupError(where, "a height field has a file or heights, one of them", "give file=\"hills.txt\"");
  HeightGrid grid;
  if (text) {
    grid = parseHeights(text, where);
  } else {
    const std::string path = resolveResource(uri, robot.xml.path());
    if (path.empty()) {
      throw SetupError(where, std::string("height file ") + uri + " is not found",
                       remedyFor(uri));
    }
    grid = readHeights(path);
  }
  const auto size = readNumbers(robot.xml, shape, "size", 2);
  if (!size) throw SetupError(where, "<haptic:shape> of a height field has no size", "give size=\"x y\" in metres");
  grid.size = Vector2((*size)[0], (*size)[1]);
  return grid;
}

/// What stands in the <geometry> of a <collision>.
const XmlElement* shapeIn(const XmlElement& collision, const std::string& where) {
  const XmlElement* geometry = collision.FirstChildElement("geometry");
  const XmlElement* shape = geometry ? geometry->FirstChildElement() : nullptr;
  if (!shape)
    throw SetupError(where, "its <collision> has no shape in <geometry>",
                     "give it a box, cylinder, sphere or mesh");
  return shape;
}

Vector3 boxSize(const XmlFile& file, const XmlElement& box, const std::string& where) {
  const auto size = readVector(file, box, "size");
  if (!size) throw SetupError(where, "<box> has no size", "give size=\"x y z\" in metres");
  return *size;
}

}  // namespace

ShapePieces CollisionShapes::make(const RobotFile& robot, const LinkXml& link, const XmlElement& collision) {
  const XmlFile& file = robot.xml;
  const std::string where = file.at(collision) + ": link '" + link.name + "'";
  const XmlElement* shape = shapeIn(collision, where);
  const std::string kind = shape->Name();
  const Refinement refinement = readRefinement(file, collision);
  if (kind == "mesh" && refinement.type == "half_space") {
    throw SetupError(where, "a half-space has a <mesh> for other tools", "give it a box, as thick as its elastic layer");
  }
  if (refinement.type == "height_field" || refinement.type == "ground") {
    return makeGround(robot, where, *collision.FirstChildElement("haptic:shape"), *shape);
  }
  if (kind == "mesh" && refinement.type.empty()) return meshes_.make(robot, link, where, collision, refinement.surface_error);
  ShapePieces made;
  std::ostringstream text;
  TessellationReport report;
  if (kind == "mesh") {
    text << "mesh";
  } else if (kind == "box") {
    const Vector3 size = boxSize(file, *shape, where);
    made.pieces.push_back(std::make_shared<ConvexPolyhedron>(makeBox(size, where)));
    text << "box " << size.x() << " × " << size.y() << " × " << size.z() << " m";
  } else if (kind == "sphere") {
    const double radius = positive(file, *shape, "radius", where);
    text << "sphere r " << radius << " m";
    if (refinement.faceted) {
      const Polyhedron hull = std::make_shared<ConvexPolyhedron>(
          makeSphere(radius, refinement.subdivision, RoundFit::kInscribed, where, &report));
      text << " (" << tessellationText(report, hull->vertexCount()) << ")";
      made.pieces.push_back(hull);
    } else {
      made.pieces.push_back(std::make_shared<Ball>(radius, where));
    }
  } else if (kind == "cylinder") {
    const double radius = positive(file, *shape, "radius", where),
                 length = positive(file, *shape, "length", where);
    text << "cylinder r " << radius << " l " << length << " m";
    if (refinement.prism) {
      const Polyhedron prism = std::make_shared<ConvexPolyhedron>(
          makeCylinder(radius, length, refinement.segments, RoundFit::kInscribed, where, &report));
      made.pieces.push_back(prism);
      text << " (" << tessellationText(report, prism->vertexCount()) << ")";
    } else {
      made.pieces.push_back(std::make_shared<Rod>(radius, length, Rod::Ends::kFlat, where));
    }
  } else if (kind == "capsule" || kind == "drake:capsule") {
    const double radius = positive(file, *shape, "radius", where),
                 length = positive(file, *shape, "length", where);
    text << "capsule r " << radius << " l " << length << " m";
    if (refinement.faceted) {
      const Polyhedron hull =
          std::make_shared<ConvexPolyhedron>(makeCapsule(radius, length, refinement.subdivision, where, &report));
      made.pieces.push_back(hull);
      text << " (" << hull->vertexCount() << " vertices)";
    } else {
      made.pieces.push_back(std::make_shared<Rod>(radius, length, Rod::Ends::kRound, where));
    }
  } else {
    throw SetupError(where, "its collision shape <" + kind + "> is not supported",
                     "use box, cylinder, sphere, capsule or mesh");
  }
  measure(made);
  made.text = text.str();
  if (!refinement.type.empty()) takeType(file, *collision.FirstChildElement("haptic:shape"), refinement.type, where, made);
  return made;
}

ShapePieces CollisionShapes::makeGround(const RobotFile& robot, const std::string& where, const XmlElement& shape,
                                        const XmlElement& geometry) {
  const bool is_mesh = std::strcmp(shape.Attribute("type"), "ground") == 0;
  if (is_mesh && std::strcmp(geometry.Name(), "mesh") != 0) {
    throw SetupError(where, std::string("ground has a <") + geometry.Name() + ">, no <mesh>",
                     "give it the mesh of its surface, or write type=\"height_field\"");
  }
  const auto thickness = readNumber(robot.xml, shape, "thickness");
  if (!thickness) {
    throw SetupError(where, "<haptic:shape> of ground has no thickness", "give in metres how deep it goes below its lowest point");
  }
  ShapePieces made;
  std::ostringstream text;
  if (is_mesh) {
    const std::string path = meshPath(robot, where, geometry);
    if (path.empty()) {
      throw SetupError(where, std::string("mesh ") + geometry.Attribute("filename") + " is not found",
                       remedyFor(geometry.Attribute("filename")));
    }
    made.picture = readMesh(path, meshScale(robot, geometry), where);
    text << "ground under mesh " << std::filesystem::path(path).filename().string();
  } else {
    const HeightGrid grid = heightsOf(robot, where, shape);
    made.picture = surfaceOf(grid, where);
    text << "height field " << grid.columns << " × " << grid.rows << " over " << grid.size.x() << " × " << grid.size.y() << " m";
  }
  GroundReport report;
  made.pieces = groundPieces(made.picture, *thickness, where, report);
  text << ", " << report.triangles << " triangles from " << report.lowest << " to " << report.highest << " m as " << report.pieces
       << " convex pieces down to " << report.base << " m, exact";
  made.text = text.str();
  made.fixed_only = "ground";
  measure(made);
  return made;
}

}  // namespace haptic
