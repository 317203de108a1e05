#include "scene/import/polygons.h"

#include "scene/errors.h"
#include "scene/import/gltf_nodes.h"
#include "scene/import/mtl_opacity.h"
#include "scene/import/ply_counts.h"
#include "scene/import/polygon_files.h"
#include "scene/import/polygon_textures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include <assimp/GltfMaterial.h>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <glm/common.hpp>
#include <glm/matrix.hpp>

namespace scene {

namespace {

/// Beyond this share of opacity a material is a surface; below, glass.
constexpr double kLeastOpacity = 0.5;
/// Normals that a file lacks are made smooth over edges that bend less than this, in degrees.
constexpr float kCreaseDegrees = 40;
/// Rays are single precision relative to the scene's middle: larger scenes lose whole metres.
constexpr double kLargestExtent = 1e7;
constexpr std::int64_t kMostTriangles = 2'000'000'000;
/// Scenes beyond these widths in metres are seldom meant in metres.
constexpr double kSmallScene = 0.5, kLargeScene = 500;
constexpr int kDeepestNode = 1000;
const glm::vec3 kGrey(0.5f);

glm::dmat4 matrixOf(const aiMatrix4x4& m) {
    return {{m.a1, m.b1, m.c1, m.d1}, {m.a2, m.b2, m.c2, m.d2}, {m.a3, m.b3, m.c3, m.d3}, {m.a4, m.b4, m.c4, m.d4}};
}

bool isFinite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

glm::vec3 vectorOf(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}

std::string textureNameOf(const aiMaterial& material, std::initializer_list<aiTextureType> types) {
    aiString name;
    for (const aiTextureType type : types)
        if (material.GetTexture(type, 0, &name) == aiReturn_SUCCESS && name.length > 0) return name.C_Str();
    return {};
}

PolygonMaterial materialOf(const aiMaterial& source, const std::map<std::string, double>& mtlOpacities,
                           PolygonTextures& textures) {
    PolygonMaterial material;
    material.name = source.GetName().C_Str();
    aiColor4D base(0.8f, 0.8f, 0.8f, 1);
    if (source.Get(AI_MATKEY_BASE_COLOR, base) != aiReturn_SUCCESS) source.Get(AI_MATKEY_COLOR_DIFFUSE, base);
    material.baseColour = glm::clamp(glm::vec3(base.r, base.g, base.b), 0.0f, 1.0f);
    if (!isFinite(material.baseColour)) material.baseColour = kGrey;

    const std::string colour = textureNameOf(source, {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE});
    if (!colour.empty()) material.colourTexture = textures.find(colour);
    if (!colour.empty() && material.colourTexture == kNoTexture) material.baseColour = kGrey;

    double opacity = 1;
    aiString alphaMode;
    if (source.Get(AI_MATKEY_GLTF_ALPHAMODE, alphaMode) == aiReturn_SUCCESS) {
        const std::string mode = alphaMode.C_Str();
        if (mode != "OPAQUE") { // nothing is half there: what blends is cut out at a half, too
            opacity = base.a;
            material.alphaTexture = material.colourTexture;
            if (mode == "MASK") source.Get(AI_MATKEY_GLTF_ALPHACUTOFF, material.alphaCut);
        }
    } else {
        float given = 1;
        if (source.Get(AI_MATKEY_OPACITY, given) == aiReturn_SUCCESS) opacity = given;
        const auto found = mtlOpacities.find(material.name);
        if (found != mtlOpacities.end()) opacity = std::min(opacity, found->second);
        const std::string mask = textureNameOf(source, {aiTextureType_OPACITY});
        if (!mask.empty()) material.alphaTexture = textures.findOpacity(mask);
    }
    float transmission = 0;
    if (source.Get(AI_MATKEY_TRANSMISSION_FACTOR, transmission) == aiReturn_SUCCESS) opacity -= transmission;
    material.isGlass = opacity < kLeastOpacity;
    return material;
}

/// Triangles with a corner that is no number are left out and counted.
PolygonMesh meshOf(const aiMesh& source, std::int64_t& brokenTriangles) {
    PolygonMesh mesh;
    mesh.name = source.mName.C_Str();
    mesh.material = source.mMaterialIndex;
    const std::size_t count = source.mNumVertices;
    mesh.positions.resize(count);
    std::vector<bool> isBroken(count);
    for (std::size_t i = 0; i < count; ++i) {
        mesh.positions[i] = vectorOf(source.mVertices[i]);
        isBroken[i] = !isFinite(mesh.positions[i]);
        if (isBroken[i]) mesh.positions[i] = glm::vec3(0);
    }
    if (source.HasNormals())
        for (std::size_t i = 0; i < count; ++i) {
            const glm::vec3 normal = vectorOf(source.mNormals[i]);
            mesh.normals.push_back(isFinite(normal) ? normal : glm::vec3(0));
        }
    if (source.HasTextureCoords(0))
        for (std::size_t i = 0; i < count; ++i) {
            const glm::vec3 place = vectorOf(source.mTextureCoords[0][i]);
            mesh.texturePlaces.push_back(isFinite(place) ? glm::vec2(place) : glm::vec2(0));
        }
    if (source.HasVertexColors(0))
        for (std::size_t i = 0; i < count; ++i) {
            const aiColor4D& c = source.mColors[0][i];
            const glm::vec3 colour(c.r, c.g, c.b);
            mesh.colours.push_back(isFinite(colour) ? glm::clamp(colour, 0.0f, 1.0f) : kGrey);
        }
    for (std::size_t i = 0; i < source.mNumFaces; ++i) {
        const aiFace& face = source.mFaces[i];
        if (face.mNumIndices != 3) continue; // lines and points
        const std::array<std::uint32_t, 3> corners{face.mIndices[0], face.mIndices[1], face.mIndices[2]};
        const bool isOutside = std::any_of(corners.begin(), corners.end(), [&](auto c) { return c >= count; });
        if (isOutside || std::any_of(corners.begin(), corners.end(), [&](auto c) { return isBroken[c]; }))
            ++brokenTriangles;
        else
            mesh.triangles.push_back(corners);
    }
    return mesh;
}

/// All nodes' meshes; those that a map squeezes flat, or that are no numbers, are left out and counted.
void placeInstances(const aiNode& node, const glm::dmat4& worldFromParent, int depth, PolygonScene& scene,
                    std::int64_t& flatInstances, const std::filesystem::path& path) {
    if (depth > kDeepestNode)
        throw Failure("holds nodes more than " + std::to_string(kDeepestNode) + " deep", path, "export it flatter");
    const glm::dmat4 worldFromNode = worldFromParent * matrixOf(node.mTransformation);
    const double determinant = glm::determinant(glm::dmat3(worldFromNode));
    const bool isFlat = !std::isfinite(determinant) || determinant == 0 || !isFinite(glm::vec3(worldFromNode[3]));
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
        if (scene.meshes[node.mMeshes[i]].triangles.empty()) continue;
        if (isFlat)
            ++flatInstances;
        else
            scene.instances.push_back({node.mMeshes[i], worldFromNode});
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i)
        placeInstances(*node.mChildren[i], worldFromNode, depth + 1, scene, flatInstances, path);
}

/// What the file says of its unit, and what its size says.
void remarkOnUnits(const aiScene& source, const glm::dvec3& extent, PolygonScene& scene) {
    float centimetres = 100;
    double preciseCentimetres = 100;
    if (source.mMetaData != nullptr) {
        source.mMetaData->Get("UnitScaleFactor", centimetres);
        if (source.mMetaData->Get("UnitScaleFactor", preciseCentimetres))
            centimetres = static_cast<float>(preciseCentimetres);
    }
    char text[160] = "";
    if (centimetres > 0 && centimetres != 100)
        std::snprintf(text, sizeof text, "the file says that its unit is %g m; it is taken for the metre all the same",
                      static_cast<double>(centimetres) / 100);
    else if (const double widest = std::max({extent.x, extent.y, extent.z});
             widest < kSmallScene || widest > kLargeScene)
        std::snprintf(text, sizeof text, "the scene is %.4g m wide if its unit is the metre, as is assumed", widest);
    if (*text != '\0') scene.remarks.emplace_back(text);
}

void remark(PolygonScene& scene, std::int64_t count, const std::string& one, const std::string& many) {
    if (count > 0) scene.remarks.push_back(std::to_string(count) + " " + (count == 1 ? one : many));
}

/// What Assimp says, in one line and short.
std::string firstLine(std::string text) {
    text = text.substr(0, text.find('\n'));
    return text.substr(0, 200);
}

} // namespace

bool isPolygonFile(const std::filesystem::path& path) {
    const Assimp::Importer importer;
    return path.has_extension() && importer.IsExtensionSupported(path.extension().string());
}

PolygonScene readPolygons(const std::filesystem::path& path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) throw Failure("no such file", path, "check the path");
    checkGltfNodes(path, kDeepestNode);
    checkPlyCounts(path);
    Assimp::Importer importer;
    std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
    auto* files = new PolygonFiles(folder); // the importer owns it
    importer.SetIOHandler(files);
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    importer.SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, kCreaseDegrees);
    const aiScene* source =
        importer.ReadFile(path.filename().string(), aiProcess_Triangulate | aiProcess_SortByPType |
                                                        aiProcess_GenSmoothNormals | aiProcess_JoinIdenticalVertices |
                                                        aiProcess_TransformUVCoords | aiProcess_ValidateDataStructure);
    const char* const remedy = "export it again from the program that made it";
    if (source == nullptr || source->mRootNode == nullptr) {
        if (files->opened().empty()) throw Failure("cannot be opened", path, "check that it may be read");
        throw Failure("cannot be read (" + firstLine(importer.GetErrorString()) + ")", path, remedy);
    }

    PolygonScene scene;
    scene.files = files->opened();
    std::map<std::string, double> mtlOpacities;
    for (const std::filesystem::path& file : files->opened())
        if (file.extension() == ".mtl") mtlOpacities.merge(readMtlOpacities(file));
    for (const std::string& refused : files->refused())
        scene.remarks.push_back("'" + refused + "' is not in the scene's folder, and was not read");

    PolygonTextures textures(*source, folder, scene);
    for (unsigned i = 0; i < source->mNumMaterials; ++i)
        scene.materials.push_back(materialOf(*source->mMaterials[i], mtlOpacities, textures));
    std::int64_t brokenTriangles = 0, flatInstances = 0;
    for (unsigned i = 0; i < source->mNumMeshes; ++i) {
        scene.meshes.push_back(meshOf(*source->mMeshes[i], brokenTriangles));
        if (scene.meshes.back().material >= scene.materials.size())
            throw Failure("names a material that it has not", path, remedy);
    }
    placeInstances(*source->mRootNode, glm::dmat4(1.0), 0, scene, flatInstances, path);
    remark(scene, brokenTriangles, "triangle has corners that are no numbers, and was left out",
           "triangles have corners that are no numbers, and were left out");
    remark(scene, flatInstances, "object is scaled to nothing, and was left out",
           "objects are scaled to nothing, and were left out");
    remark(scene,
           std::count_if(scene.materials.begin(), scene.materials.end(), [](const auto& m) { return m.isGlass; }),
           "material is glass: light and looks go through, nothing is drawn of it",
           "materials are glass: light and looks go through, nothing is drawn of them");

    if (countTriangles(scene) == 0)
        throw Failure("holds no triangles", path, "export surfaces, not only points, lines or cameras");
    if (countTriangles(scene) > kMostTriangles)
        throw Failure("holds more than " + std::to_string(kMostTriangles) + " triangles", path, "divide it");
    const PolygonBounds bounds = boundsOf(scene);
    const glm::dvec3 extent = bounds.high - bounds.low;
    if (!(std::max({extent.x, extent.y, extent.z}) <= kLargestExtent))
        throw Failure("is wider than " + std::to_string(static_cast<long>(kLargestExtent)) + " m", path,
                      "remove what lies so far away, or scale it");
    remarkOnUnits(*source, extent, scene);
    return scene;
}

} // namespace scene
