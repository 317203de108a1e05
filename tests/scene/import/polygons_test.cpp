#include "scene/import/polygons.h"

#include "scene/errors.h"

#include "tests/scene/scratch_folder.h"

#include <algorithm>
#include <cstring>

#include <glm/matrix.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace scene {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// 2 x 2 pixels, BGRA: red and half-seen green above, blue and white below.
void writePicture(const std::filesystem::path& path) {
    cv::Mat4b picture(2, 2);
    picture(0, 0) = {0, 0, 255, 255}, picture(0, 1) = {0, 255, 0, 128};
    picture(1, 0) = {255, 0, 0, 255}, picture(1, 1) = {255, 255, 255, 255};
    ASSERT_TRUE(cv::imwrite(path.string(), picture));
}

constexpr const char* kSquare = "mtllib a.mtl\nusemtl m\n"
                                "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\n"
                                "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                                "f 1/1 2/2 3/3 4/4\n";

/// A scene of kSquare with these materials.
PolygonScene squareWith(const ScratchFolder& folder, const std::string& mtl) {
    writeFile(folder / "a.obj", kSquare);
    writeFile(folder / "a.mtl", mtl);
    return readPolygons(folder / "a.obj");
}

// Assimp falls over them.
TEST(Polygons, WhatStandsBeforeTheFirstMaterialBelongsToNone) {
    const ScratchFolder folder;
    writePicture(folder / "p.png");
    for (const std::string before :
         {"Kd 1 0 0\n", "m\nmap_Kd p.png\nNs 3\n", "illum 2\r\nd 0.5\r\n", " Ka 0 0 0\n\n"}) {
        const PolygonScene scene = squareWith(folder, before + "newmtl m\nKd 0.5 0.25 1\n");
        EXPECT_EQ(countTriangles(scene), 2) << before;
        EXPECT_EQ(scene.materials[scene.meshes[0].material].baseColour, glm::vec3(0.5f, 0.25f, 1)) << before;
        EXPECT_EQ(countTriangles(squareWith(folder, before)), 2) << "no material at all: " << before;
    }
    for (const std::string named :
         {"\xef\xbb\xbfnewmtl m\n", "# of old\rnewmtl m\r", " newmtl m\n", "\t newmtl m\r\n"}) {
        const PolygonScene scene = squareWith(folder, named + "Kd 0.5 0.25 1\n");
        EXPECT_EQ(scene.materials[scene.meshes[0].material].baseColour, glm::vec3(0.5f, 0.25f, 1)) << named;
    }
    writeFile(folder / "b.obj", "mtllib B.TXT\nv 0 0 0\nv 2 0 0\nv 2 1 0\nf 1 2 3\n");
    writeFile(folder / "B.TXT", "Kd 1 0 0\n");
    EXPECT_EQ(countTriangles(readPolygons(folder / "b.obj")), 1) << "files of materials may be called anything";
}

TEST(Polygons, AnObjWithItsMaterials) {
    const ScratchFolder folder;
    writePicture(folder / "p.png");
    const PolygonScene scene = squareWith(folder, "newmtl m\nKd 0.5 0.25 1\nmap_Kd p.png\nmap_d p.png\n");
    EXPECT_EQ(countTriangles(scene), 2);
    const PolygonBounds bounds = boundsOf(scene);
    EXPECT_EQ(bounds.low, glm::dvec3(0));
    EXPECT_EQ(bounds.high, glm::dvec3(2, 1, 0));
    ASSERT_EQ(scene.textures.size(), 1u) << "a picture that is colour and mask is read once";
    EXPECT_EQ(scene.textures[0].pixels(1, 0), (Rgba8{0, 255, 0, 128}));
    EXPECT_EQ(scene.textures[0].pixels(0, 1), (Rgba8{0, 0, 255, 255}));
    const PolygonMesh& mesh = scene.meshes[scene.instances[0].mesh];
    const PolygonMaterial& material = scene.materials[mesh.material];
    EXPECT_EQ(material.baseColour, glm::vec3(0.5f, 0.25f, 1));
    EXPECT_EQ(material.colourTexture, 0);
    EXPECT_EQ(material.alphaTexture, 0);
    EXPECT_EQ(material.alphaCut, 0.5f);
    EXPECT_FALSE(material.isGlass);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        EXPECT_EQ(mesh.texturePlaces[i], glm::vec2(mesh.positions[i].x / 2, mesh.positions[i].y)) << "v runs up";
        EXPECT_EQ(mesh.normals[i], glm::vec3(0, 0, 1));
    }
    EXPECT_EQ(scene.files.size(), 3u);
    EXPECT_TRUE(scene.remarks.empty());
}

TEST(Polygons, AMaskWithoutAlphaIsItsBrightness) {
    const ScratchFolder folder;
    cv::Mat1b mask(1, 2);
    mask(0, 0) = 10, mask(0, 1) = 200;
    ASSERT_TRUE(cv::imwrite((folder / "mask.png").string(), mask));
    const PolygonScene scene = squareWith(folder, "newmtl m\nmap_d mask.png\n");
    const PolygonMaterial& material = scene.materials[scene.meshes[0].material];
    ASSERT_NE(material.alphaTexture, kNoTexture);
    EXPECT_EQ(material.colourTexture, kNoTexture);
    const auto& alpha = scene.textures[static_cast<std::size_t>(material.alphaTexture)].pixels;
    EXPECT_EQ(alpha(0, 0).a, 10);
    EXPECT_EQ(alpha(1, 0).a, 200);
}

TEST(Polygons, GlassIsLessThanHalfOpaqueHoweverItIsWritten) {
    for (const char* glass : {"d 0.2", "Tr 0.8", "Kd 1 1 1 0.01"}) {
        const ScratchFolder folder;
        const PolygonScene scene = squareWith(folder, std::string("newmtl m\n") + glass + "\n");
        EXPECT_TRUE(scene.materials[scene.meshes[0].material].isGlass) << glass;
        EXPECT_THAT(scene.remarks, Contains(HasSubstr("glass"))) << glass;
    }
    for (const char* solid : {"d 0.7", "Tr 0.3", "Kd 1 1 1 0.7", "Kd 1 1 1"}) {
        const ScratchFolder folder;
        EXPECT_FALSE(squareWith(folder, std::string("newmtl m\n") + solid + "\n").materials.back().isGlass) << solid;
    }
}

TEST(Polygons, TexturesThatCannotBeHadAreNamedAndGrey) {
    const ScratchFolder outer;
    std::filesystem::create_directory(outer / "scene");
    writePicture(outer / "outside.png");
    std::filesystem::create_symlink(outer / "outside.png", outer / "scene/link.png");
    writeFile(outer / "scene/damaged.png", "no picture");
    writeFile(outer / "scene/a.obj", kSquare);
    for (const auto& [name, why] :
         {std::pair("missing.png", "is not there"), std::pair("damaged.png", "is damaged"),
          std::pair("../outside.png", "lies outside"), std::pair("link.png", "lies outside")}) {
        writeFile(outer / "scene/a.mtl", std::string("newmtl m\nKd 1 0 0\nmap_Kd ") + name + "\n");
        const PolygonScene scene = readPolygons(outer / "scene/a.obj");
        EXPECT_THAT(scene.remarks, Contains(testing::AllOf(HasSubstr(name), HasSubstr(why), HasSubstr("grey"))))
            << name;
        const PolygonMaterial& material = scene.materials[scene.meshes[0].material];
        EXPECT_EQ(material.colourTexture, kNoTexture);
        EXPECT_EQ(material.baseColour, glm::vec3(0.5f));
    }
}

TEST(Polygons, FoldersOfOtherSystemsAreFound) {
    const ScratchFolder folder;
    std::filesystem::create_directory(folder / "maps");
    writePicture(folder / "maps/p.png");
    EXPECT_EQ(squareWith(folder, "newmtl m\nmap_Kd maps\\p.png\n").textures.size(), 1u);
}

TEST(Polygons, AnObjWithoutItsMaterialsIsReadAndSaysSo) {
    const ScratchFolder folder;
    writeFile(folder / "a.obj", kSquare);
    const PolygonScene scene = readPolygons(folder / "a.obj");
    EXPECT_EQ(countTriangles(scene), 2);
    EXPECT_THAT(scene.remarks, Contains(HasSubstr("a.mtl")));
}

constexpr const char* kPlyHeader = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                                   "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

TEST(Polygons, APlyIsReadIfItIsAsLongAsItClaims) {
    const ScratchFolder folder;
    const std::filesystem::path path = folder / "a.ply";
    const std::string text =
        std::string("ply\nformat ascii 1.0\n") + kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2"; // no end of line
    std::string binary = std::string("ply\nformat binary_little_endian 1.0\n") + kPlyHeader;
    for (const float value : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f})
        binary.append(reinterpret_cast<const char*>(&value), sizeof value);
    binary += '\3';
    for (const std::int32_t corner : {0, 1, 2})
        binary.append(reinterpret_cast<const char*>(&corner), sizeof corner);
    std::string windows = text; // and blanks, which Assimp passes over
    windows.replace(windows.find("end_header\n"), 11, "comment element vertex 9000000\r\nend_header \r\n");
    for (const std::string& whole : {text, binary, windows}) {
        writeFile(path, whole);
        EXPECT_EQ(countTriangles(readPolygons(path)), 1);
        for (const auto& [from, to] : {std::pair("vertex 3", "vertex 400000000"), std::pair("face 1", "face 50")}) {
            std::string claimed = whole;
            claimed.replace(claimed.find(from), std::strlen(from), to);
            writeFile(path, claimed);
            EXPECT_THAT(failureOf<Failure>([&] { readPolygons(path); }), HasSubstr("for which it is too short")) << to;
        }
    }
}

// Assimp looks for the end of such a header for ever.
TEST(Polygons, APlyWhoseHeaderHasNoEndIsRefused) {
    const ScratchFolder folder;
    const std::filesystem::path path = folder / "a.ply";
    const std::string whole = std::string("ply\nformat ascii 1.0\n") + kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    for (const std::string instead :
         {"end_hea", "end_headers\n", "property int x end_header\n", "comment end_header\n"}) {
        std::string damaged = whole;
        damaged.replace(damaged.find("end_header\n"), 11, instead);
        writeFile(path, damaged);
        EXPECT_THAT(failureOf<Failure>([&] { readPolygons(path); }), HasSubstr("header without an end")) << instead;
    }
    writeFile(path, whole.substr(0, whole.find("end_header")) + "  " + whole.substr(whole.find("end_header")));
    EXPECT_EQ(countTriangles(readPolygons(path)), 1);
}

/// One square in three nodes: where it is, moved, and moved and mirrored; cut out at 0.3.
std::string gltf() {
    return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
 "nodes": [{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0]},
           {"mesh": 0, "translation": [0, 7, 0], "scale": [-1, 1, 1]}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
 "materials": [{"name": "leaf", "alphaMode": "MASK", "alphaCutoff": 0.3, "doubleSided": true,
                "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.4, 0.6, 1], "baseColorTexture": {"index": 0}}}],
 "textures": [{"source": 0}], "images": [{"uri": "p.png"}],
 "buffers": [{"uri": "square.bin", "byteLength": 92}],
 "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
                 {"buffer": 0, "byteOffset": 80, "byteLength": 12}],
 "accessors": [
  {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [2, 1, 0]},
  {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
  {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}]})";
}

void writeGltf(const ScratchFolder& folder) {
    // glTF's v runs down.
    const float numbers[] = {0, 0, 0, 2, 0, 0, 2, 1, 0, 0, 1, 0, 0, 1, 1, 1, 1, 0, 0, 0};
    const std::uint16_t indices[] = {0, 1, 2, 0, 2, 3};
    std::string bytes(sizeof numbers + sizeof indices, '\0');
    std::memcpy(bytes.data(), numbers, sizeof numbers);
    std::memcpy(bytes.data() + sizeof numbers, indices, sizeof indices);
    writeFile(folder / "square.bin", bytes);
    writeFile(folder / "a.gltf", gltf());
    writePicture(folder / "p.png");
}

TEST(Polygons, AGltfWithInstancesAndAMask) {
    const ScratchFolder folder;
    writeGltf(folder);
    const PolygonScene scene = readPolygons(folder / "a.gltf");
    ASSERT_EQ(scene.meshes.size(), 1u);
    ASSERT_EQ(scene.instances.size(), 3u);
    EXPECT_EQ(countTriangles(scene), 6);
    EXPECT_EQ(scene.instances[1].worldFromMesh[3], glm::dvec4(5, 0, 0, 1));
    EXPECT_LT(glm::determinant(glm::dmat3(scene.instances[2].worldFromMesh)), 0);
    EXPECT_EQ(boundsOf(scene).low, glm::dvec3(-2, 0, 0));
    EXPECT_EQ(boundsOf(scene).high, glm::dvec3(7, 8, 0));
    const PolygonMaterial& material = scene.materials[scene.meshes[0].material];
    EXPECT_EQ(material.name, "leaf");
    EXPECT_EQ(material.baseColour, glm::vec3(0.2f, 0.4f, 0.6f));
    EXPECT_EQ(material.colourTexture, 0);
    EXPECT_EQ(material.alphaTexture, 0);
    EXPECT_FLOAT_EQ(material.alphaCut, 0.3f);
    const PolygonMesh& mesh = scene.meshes[0];
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        EXPECT_EQ(mesh.texturePlaces[i], glm::vec2(mesh.positions[i].x / 2, mesh.positions[i].y)) << "v runs up";
    EXPECT_TRUE(scene.remarks.empty());
}

TEST(Polygons, AFileThatIsCutAnywhereIsReadOrRefusedInOneLine) {
    const ScratchFolder folder;
    writeGltf(folder);
    const std::string whole = gltf();
    for (std::size_t length = 0; length < whole.size(); length += 41) {
        writeFile(folder / "cut.gltf", whole.substr(0, length));
        const std::string failure = failureOf<Failure>([&] { readPolygons(folder / "cut.gltf"); });
        EXPECT_THAT(failure, HasSubstr("cut.gltf")) << length;
        EXPECT_THAT(failure, Not(HasSubstr("\n"))) << length;
    }
    const std::string bytes = bytesOfFile(folder / "square.bin");
    for (const std::size_t length : {std::size_t{0}, std::size_t{1}, std::size_t{50}, bytes.size() - 1}) {
        writeFile(folder / "square.bin", bytes.substr(0, length));
        EXPECT_THAT(failureOf<Failure>([&] { readPolygons(folder / "a.gltf"); }), HasSubstr("a.gltf")) << length;
    }
    std::filesystem::remove(folder / "square.bin");
    EXPECT_THAT(failureOf<Failure>([&] { readPolygons(folder / "a.gltf"); }), HasSubstr("a.gltf"));
}

// A few kilobytes that would take the stack, or all memory.
TEST(Polygons, NodesThatAreNoTreeOrTooDeepAreRefused) {
    const ScratchFolder folder;
    const auto refused = [&](const std::vector<std::string>& children) {
        std::string nodes;
        for (const std::string& of : children)
            nodes += "{\"children\": [" + of + "]}, ";
        const std::string text = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [)" +
                                 nodes + R"({"name": "last"}]})";
        std::string chunk(4, '\0');
        const auto length = static_cast<std::uint32_t>(text.size()), all = length + 20, version = std::uint32_t{2};
        std::string glb = "glTF";
        for (const std::uint32_t word : {version, all, length, std::uint32_t{0x4E4F534A}}) {
            std::memcpy(chunk.data(), &word, chunk.size());
            glb += chunk;
        }
        writeFile(folder / "a.gltf", text);
        writeFile(folder / "a.glb", glb + text);
        const std::string failure = failureOf<Failure>([&] { readPolygons(folder / "a.gltf"); });
        const std::string ofBinary = failureOf<Failure>([&] { readPolygons(folder / "a.glb"); });
        EXPECT_EQ(failure.substr(failure.find("a.gltf") + 6), ofBinary.substr(ofBinary.find("a.glb") + 5));
        return failure;
    };
    std::vector<std::string> chain, twice;
    for (int i = 1; i <= 50000; ++i)
        chain.push_back(std::to_string(i));
    EXPECT_THAT(refused(chain), HasSubstr("more than 1000 deep"));
    for (int i = 1; i <= 40; ++i)
        twice.push_back(std::to_string(i) + ", " + std::to_string(i));
    EXPECT_THAT(refused(twice), HasSubstr("node 1 is a child twice"));
    EXPECT_THAT(refused({"1", "0"}), HasSubstr("more than 1000 deep")) << "a circle";
}

TEST(Polygons, WhatIsNoNumberIsLeftOutAndCounted) {
    const ScratchFolder folder;
    writeFile(folder / "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv inf 1 1\nf 1 2 3\nf 1 2 4\nf 2 3 5\n");
    const PolygonScene scene = readPolygons(folder / "a.obj");
    EXPECT_EQ(countTriangles(scene), 1);
    EXPECT_THAT(scene.remarks, Contains("2 triangles have corners that are no numbers, and were left out"));
}

TEST(Polygons, FilesWithNothingInThemSayWhatToDo) {
    const ScratchFolder folder;
    const auto failureWith = [&](const std::string& text) {
        writeFile(folder / "a.obj", text);
        const std::string failure = failureOf<Failure>([&] { readPolygons(folder / "a.obj"); });
        EXPECT_THAT(failure, HasSubstr((folder / "a.obj").string()));
        EXPECT_THAT(failure, Not(HasSubstr("\n")));
        return failure;
    };
    EXPECT_NE(failureWith(""), "");
    EXPECT_NE(failureWith("no scene at all\n"), "");
    EXPECT_NE(failureWith("v 0 0 0\nv 1 0 0\nl 1 2\n"), "");
    EXPECT_THAT(failureWith("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), HasSubstr("no triangles"));
    EXPECT_THAT(failureWith("v 0 0 0\nv 1e9 0 0\nv 0 1 0\nf 1 2 3\n"), HasSubstr("wider than"));
    EXPECT_NE(failureWith("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n"), "");
    EXPECT_THAT(failureOf<Failure>([&] { readPolygons(folder / "none.obj"); }), HasSubstr("no such file"));
}

TEST(Polygons, SizesThatAreSeldomMetresAreRemarkedOn) {
    const ScratchFolder folder;
    writeFile(folder / "a.obj", "v 0 0 0\nv 3720 0 0\nv 0 1 0\nf 1 2 3\n");
    EXPECT_THAT(readPolygons(folder / "a.obj").remarks, Contains(HasSubstr("3720 m wide")));
}

TEST(Polygons, KnowsFilesByTheirEnding) {
    EXPECT_TRUE(isPolygonFile("a/room.gltf"));
    EXPECT_TRUE(isPolygonFile("ROOM.GLB"));
    EXPECT_TRUE(isPolygonFile("room.obj"));
    EXPECT_FALSE(isPolygonFile("room.e57"));
    EXPECT_FALSE(isPolygonFile("room"));
}

} // namespace
} // namespace scene
