// Real scan files of others: each becomes faces that hold every point, or is refused by name and cause.

#include "scene/errors.h"
#include "scene/import/e57.h"
#include "scene/import/ptx.h"
#include "scene/project/cube_faces.h"
#include "tests/shared_data.h"

#include <algorithm>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

std::vector<std::filesystem::path> samplesOf(const std::string& extension) {
    std::vector<std::filesystem::path> paths;
    const auto folder = tests::dataFolder() / "scan_format_samples";
    if (!std::filesystem::exists(folder)) return paths;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.path().extension() == extension) paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    return paths;
}

// The scans of a file, or the failure's message.
std::string buildFaces(const std::filesystem::path& path, int& scans) {
    try {
        std::vector<std::string> remarks;
        const bool isPtx = path.extension() == ".ptx";
        for (const ScanSource& source : isPtx ? listPtx(path, remarks) : listE57(path, remarks)) {
            const Scan scan = isPtx ? readPtxScan(source) : readE57Scan(source);
            const CubeFaces faces = projectToCubeFaces(scan);
            EXPECT_EQ(faces.report.held + faces.report.dropped, faces.report.points) << path;
            EXPECT_EQ(faces.report.dropped, 0) << path << " " << source.name;
            EXPECT_EQ(faces.faces.empty(), scan.pointsInScanner.empty()) << path;
            for (const DepthImage& face : faces.faces)
                EXPECT_TRUE(isUsable(face.camera)) << face.name;
            ++scans;
        }
    } catch (const Failure& failure) {
        const std::string message = failure.what();
        EXPECT_EQ(message.find(path.string()), 0u) << message;
        return message;
    }
    return {};
}

TEST(ScanSamples, EveryE57IsBuiltOrRefused) {
    const auto paths = samplesOf(".e57");
    if (paths.empty()) GTEST_SKIP() << "because there is no scan_format_samples folder in " << tests::dataFolder();
    int scans = 0;
    for (const auto& path : paths) {
        const std::string message = buildFaces(path, scans);
        const bool mustFail = path.filename() == "bad-crc.e57";
        EXPECT_EQ(message.empty(), !mustFail) << path << ": " << message;
    }
    EXPECT_GT(scans, 15);
}

TEST(ScanSamples, EveryPtxIsBuiltOrRefused) {
    const auto paths = samplesOf(".ptx");
    if (paths.empty()) GTEST_SKIP() << "because there is no scan_format_samples folder in " << tests::dataFolder();
    int scans = 0;
    for (const auto& path : paths) {
        const std::string message = buildFaces(path, scans);
        if (path.filename() == "multiple-and-transform.ptx")
            EXPECT_NE(message.find("line 10: the transform"), std::string::npos) << "it stretches Z: " << message;
        else
            EXPECT_EQ(message, "") << path;
    }
}

TEST(ScanSamples, APoseOfTranslationAlone) {
    const auto path = tests::dataFolder() / "scan_format_samples" / "translationWithoutRotation.e57";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "because there is no " << path;
    std::vector<std::string> remarks;
    EXPECT_EQ(listE57(path, remarks).at(0).worldFromScanner.translation, glm::dvec3(4, 5, 6));
}

TEST(ScanSamples, ThePumpKeepsEveryPoint) {
    const auto path = tests::dataFolder() / "e57_pump" / "pumpAVisualReferenceImage.e57";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "because there is no " << path;
    std::vector<std::string> remarks;
    const auto sources = listE57(path, remarks);
    ASSERT_EQ(sources.size(), 1u);
    EXPECT_EQ(sources[0].rows, 1074);
    EXPECT_EQ(sources[0].columns, 345);
    const Scan scan = readE57Scan(sources[0]);
    EXPECT_EQ(scan.pointsInScanner.size(), 155201u);
    EXPECT_TRUE(scan.hasColour);
    const CubeFaces faces = projectToCubeFaces(scan);
    EXPECT_EQ(faces.report.held, 155201);
    EXPECT_EQ(faces.report.dropped, 0);
    EXPECT_NEAR(faces.report.columnStepRadians, 0.00437, 1e-5);
    EXPECT_NEAR(faces.report.rowStepRadians, 0.00118, 1e-5);
    ASSERT_FALSE(faces.faces.empty());
    EXPECT_EQ(faces.faces[0].name, "pumpA-front") << "its 86 degrees stand in one face";
    for (const DepthImage& face : faces.faces)
        for (int y = 0; y < face.camera.height; ++y)
            for (int x = 0; x < face.camera.width; ++x) {
                if (!isSurface(face.flags(x, y))) continue;
                const double range = glm::length(rayThrough(face.camera, x + 0.5, y + 0.5)) / face.disparity(x, y);
                ASSERT_GT(range, 1.95) << face.name << " " << x << " " << y;
                ASSERT_LT(range, 5.47) << face.name << " " << x << " " << y;
            }
    const auto images = listE57Images(path);
    ASSERT_EQ(images.size(), 1u);
    EXPECT_EQ(images[0].kind, E57ImageKind::visualReference);
    const Image<Rgb8> picture = readE57Image(images[0]);
    EXPECT_EQ(picture.width(), 3072);
    EXPECT_EQ(picture.height(), 2304);
}

} // namespace
} // namespace scene
