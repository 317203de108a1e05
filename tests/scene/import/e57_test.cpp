// What E57 files hold, read back exactly; every file here is written by the test itself.

#include "scene/import/e57.h"

#include "scene/errors.h"
#include "tests/scene/import/written_e57.h"

#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

namespace scene {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

class E57 : public testing::Test {
  protected:
    std::vector<ScanSource> list(const std::string& name = "a.e57") { return listE57(folder_ / name, remarks_); }
    Scan readOne(const WrittenScan& scan) {
        writeE57(folder_ / "a.e57", {scan});
        const auto sources = list();
        EXPECT_EQ(sources.size(), 1u);
        return readE57Scan(sources.at(0));
    }
    std::string failureOf(const WrittenScan& scan) {
        try {
            readOne(scan);
        } catch (const Failure& failure) {
            return failure.what();
        }
        return "no failure";
    }

    TemporaryFolder folder_;
    std::vector<std::string> remarks_;
};

TEST_F(E57, DoublesBecomePointsAboutTheScanner) {
    const Scan scan = readOne({"hall", {}, cartesian({1, -2.5}, {2, 0}, {3, 7})});
    ASSERT_EQ(scan.pointsInScanner.size(), 2u);
    EXPECT_EQ(scan.name, "hall");
    EXPECT_EQ(scan.pointsInScanner[0], glm::vec3(1, 2, 3));
    EXPECT_EQ(scan.pointsInScanner[1], glm::vec3(-2.5f, 0, 7));
    EXPECT_EQ(toMatrix(scan.worldFromScanner), glm::dmat4(1.0)) << "a missing pose is the identity";
    EXPECT_FALSE(scan.hasColour);
    EXPECT_EQ(scan.colours[0], (Rgb8{128, 128, 128}));
    EXPECT_EQ(scan.rows, 0);
    EXPECT_TRUE(scan.row.empty());
}

TEST_F(E57, EveryNumberTypeIsRead) {
    const Scan scan = readOne({"types",
                               {},
                               {{"cartesianX", NumberType::float32, {0.5, 1.5}},
                                {"cartesianY", NumberType::scaled, {0.123, -0.25}, -1000, 1000, 0.001, 0},
                                {"cartesianZ", NumberType::integer, {4, -5}, -8, 7}}});
    EXPECT_EQ(scan.pointsInScanner[0].x, 0.5f);
    EXPECT_FLOAT_EQ(scan.pointsInScanner[0].y, 0.123f);
    EXPECT_FLOAT_EQ(scan.pointsInScanner[1].y, -0.25f);
    EXPECT_EQ(scan.pointsInScanner[1].z, -5.0f);
}

TEST_F(E57, SphericalCoordinatesAreRangeAzimuthElevation) {
    const double azimuth = 0.7, elevation = -0.3, range = 12.5;
    const Scan scan = readOne({"turn",
                               {},
                               {{"sphericalRange", NumberType::float64, {range, 2}},
                                {"sphericalAzimuth", NumberType::float64, {azimuth, 0}},
                                {"sphericalElevation", NumberType::float64, {elevation, 0}},
                                {"sphericalInvalidState", NumberType::integer, {0, 1}, 0, 2}}});
    ASSERT_EQ(scan.pointsInScanner.size(), 1u);
    EXPECT_EQ(scan.invalidPoints, 1);
    const glm::dvec3 expected(range * std::cos(elevation) * std::cos(azimuth),
                              range * std::cos(elevation) * std::sin(azimuth), range * std::sin(elevation));
    EXPECT_LT(glm::distance(glm::dvec3(scan.pointsInScanner[0]), expected), 1e-6);
}

TEST_F(E57, InvalidAndNonFinitePointsAreCountedNotKept) {
    WrittenScan scan{"bad", {}, cartesian({1, 2, kNan, 4, 5}, {0, 0, 0, INFINITY, 0}, {0, 0, 0, 0, 1e300})};
    scan.fields.push_back({"cartesianInvalidState", NumberType::integer, {0, 2, 0, 0, 0}, 0, 2});
    const Scan read = readOne(scan);
    ASSERT_EQ(read.pointsInScanner.size(), 1u);
    EXPECT_EQ(read.pointsInScanner[0].x, 1.0f);
    EXPECT_EQ(read.invalidPoints, 4);
}

TEST_F(E57, GridIndicesCountFromZeroWhateverTheirStart) {
    WrittenScan scan{"grid", {}, cartesian({1, 1, 1}, {0, 1, 2}, {0, 0, 1})};
    scan.fields.push_back({"rowIndex", NumberType::integer, {17, 17, 18}, 0, 100});
    scan.fields.push_back({"columnIndex", NumberType::integer, {-3, -2, -1}, -10, 10});
    scan.indexBounds = {{"rowMinimum", 17}, {"rowMaximum", 18}, {"columnMinimum", -3}, {"columnMaximum", -1}};
    const Scan read = readOne(scan);
    EXPECT_EQ(read.rows, 2);
    EXPECT_EQ(read.columns, 3);
    EXPECT_EQ(read.row, (std::vector<std::int32_t>{0, 0, 1}));
    EXPECT_EQ(read.column, (std::vector<std::int32_t>{0, 1, 2}));
    const ScanSource source = list().at(0);
    EXPECT_EQ(source.rows, 2);
    EXPECT_EQ(source.columns, 3);
    EXPECT_EQ(source.pointCount, 3);
}

TEST_F(E57, AnAbsurdGridIsNoGrid) {
    WrittenScan scan{"grid", {}, cartesian({1, 1}, {0, 1}, {0, 0})};
    scan.fields.push_back({"rowIndex", NumberType::integer, {0, 2e9}, 0, 2000000000});
    scan.fields.push_back({"columnIndex", NumberType::integer, {0, 2e9}, 0, 2000000000});
    const Scan read = readOne(scan);
    EXPECT_EQ(read.rows, 0);
    EXPECT_TRUE(read.row.empty());
    EXPECT_EQ(read.pointsInScanner.size(), 2u);
}

TEST_F(E57, ColourIsScaledByItsLimits) {
    WrittenScan scan{"colour", {}, cartesian({1, 2, 3}, {0, 0, 0}, {0, 0, 0})};
    for (const char* name : {"colorRed", "colorGreen", "colorBlue"})
        scan.fields.push_back({name, NumberType::integer, {0, 32768, 65535}, 0, 65535});
    scan.fields.push_back({"isColorInvalid", NumberType::integer, {1, 0, 0}, 0, 1});
    scan.colorLimits = {{"colorRedMinimum", 0},       {"colorRedMaximum", 65535}, {"colorGreenMinimum", 0},
                        {"colorGreenMaximum", 65535}, {"colorBlueMinimum", 0},    {"colorBlueMaximum", 65535}};
    const Scan read = readOne(scan);
    EXPECT_TRUE(read.hasColour);
    EXPECT_EQ(read.colours[0], (Rgb8{128, 128, 128})) << "marked invalid";
    EXPECT_EQ(read.colours[1], (Rgb8{128, 128, 128}));
    EXPECT_EQ(read.colours[2], (Rgb8{255, 255, 255}));
    EXPECT_EQ(read.isColoured, (std::vector<bool>{false, true, true}));
    scan.colorLimits.clear();
    EXPECT_EQ(readOne(scan).colours[2], (Rgb8{255, 255, 255})) << "the field's own bounds serve as well";
}

TEST_F(E57, WithoutColourAPointIsAsBrightAsWhatCameBack) {
    WrittenScan scan{"colour", {}, cartesian({1, 2, 3}, {0, 0, 0}, {0, 0, 0})};
    for (const char* name : {"colorRed", "colorGreen", "colorBlue"})
        scan.fields.push_back({name, NumberType::integer, {7, 7, 7}, 0, 255});
    scan.fields.push_back({"intensity", NumberType::float32, {0, 50, 100}});
    scan.fields.push_back({"isColorInvalid", NumberType::integer, {1, 0, 1}, 0, 1});
    Scan read = readOne(scan);
    EXPECT_TRUE(read.hasColour);
    EXPECT_EQ(read.isColoured, (std::vector<bool>{false, true, false}));
    EXPECT_EQ(read.colours, (std::vector<Rgb8>{{0, 0, 0}, {7, 7, 7}, {255, 255, 255}}));
    scan.fields.back().values = {1, 1, 1};
    read = readOne(scan);
    EXPECT_FALSE(read.hasColour);
    EXPECT_TRUE(read.isColoured.empty());
    EXPECT_EQ(read.colours[1], (Rgb8{128, 128, 128})) << "halfway";
    scan.fields.back().values = {0, 0, 0};
    read = readOne(scan);
    EXPECT_TRUE(read.hasColour);
    EXPECT_TRUE(read.isColoured.empty());
    EXPECT_EQ(read.colours[0], (Rgb8{7, 7, 7}));
}

TEST_F(E57, FloatColoursWithoutLimitsAreTakenAsUnits) {
    WrittenScan scan{"colour", {}, cartesian({1, 2}, {0, 0}, {0, 0})};
    for (const char* name : {"colorRed", "colorGreen", "colorBlue"})
        scan.fields.push_back({name, NumberType::float32, {0.2, 1.0}});
    const Scan read = readOne(scan);
    EXPECT_EQ(read.colours[0], (Rgb8{51, 51, 51}));
    EXPECT_EQ(read.colours[1], (Rgb8{255, 255, 255}));
}

TEST_F(E57, IntensityBecomesGrey) {
    WrittenScan scan{"grey", {}, cartesian({1, 2, 3}, {0, 0, 0}, {0, 0, 0})};
    scan.fields.push_back({"intensity", NumberType::float32, {-100, 0, 300}});
    scan.intensityLimits = {{"intensityMinimum", -100}, {"intensityMaximum", 410}};
    Scan read = readOne(scan);
    EXPECT_FALSE(read.hasColour);
    EXPECT_EQ(read.colours[0], (Rgb8{0, 0, 0}));
    EXPECT_EQ(read.colours[1], (Rgb8{50, 50, 50}));
    EXPECT_EQ(read.colours[2], (Rgb8{200, 200, 200}));
    scan.intensityLimits.clear();
    read = readOne(scan);
    EXPECT_EQ(read.colours[0], (Rgb8{0, 0, 0})) << "the observed range where no limits stand";
    EXPECT_EQ(read.colours[2], (Rgb8{255, 255, 255}));
}

TEST_F(E57, SeveralScansKeepTheirOwnPosesAndNames) {
    const double half = std::sqrt(0.5);
    writeE57(folder_ / "a.e57", {{"room 1", WrittenPose{half, 0, 0, half, 4, 5, 6}, cartesian({1}, {0}, {0})},
                                 {"room/1", {}, cartesian({2, 3}, {0, 0}, {0, 0})},
                                 {"", {}, cartesian({}, {}, {})}});
    const auto sources = list();
    ASSERT_EQ(sources.size(), 3u);
    EXPECT_EQ(sources[0].name, "room_1");
    EXPECT_EQ(sources[1].name, "room_1-2") << "names become file names and stay apart";
    EXPECT_EQ(sources[2].name, "a-3");
    EXPECT_EQ(sources[1].pointCount, 2);
    const Scan first = readE57Scan(sources[0]);
    EXPECT_LT(glm::distance(first.worldFromScanner * glm::dvec3(1, 0, 0), glm::dvec3(4, 6, 6)), 1e-12);
    EXPECT_EQ(readE57Scan(sources[1]).pointsInScanner[1].x, 3.0f);
    const Scan empty = readE57Scan(sources[2]);
    EXPECT_TRUE(empty.pointsInScanner.empty());
}

TEST_F(E57, AQuaternionNeedNotBeNormalisedButMustTurn) {
    const Scan scan = readOne({"big", WrittenPose{1e90, 0, 0, 1e90, 0, 0, 0}, cartesian({1}, {0}, {0})});
    EXPECT_LT(glm::distance(scan.worldFromScanner * glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)), 1e-12);
    const std::string message = failureOf({"turned", WrittenPose{0, 0, 0, 0, 1, 2, 3}, cartesian({1}, {0}, {0})});
    EXPECT_NE(message.find("a.e57: the pose of scan 'turned'"), std::string::npos) << message;
}

TEST_F(E57, NationalGridOffsetsMoveIntoThePose) {
    const glm::dvec3 grid(683123.0, 5247456.0, 412.0);
    std::vector<double> x, y, z;
    for (int i = 0; i < 100; ++i) {
        x.push_back(grid.x + 0.0001 * i);
        y.push_back(grid.y - 5 + 0.1 * i);
        z.push_back(grid.z + 0.01 * i);
    }
    const Scan scan = readOne({"grid", WrittenPose{1, 0, 0, 0, 10, 0, 0}, cartesian(x, y, z)});
    ASSERT_EQ(scan.pointsInScanner.size(), x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
        const glm::dvec3 inWorld = scan.worldFromScanner * glm::dvec3(scan.pointsInScanner[i]);
        EXPECT_LT(glm::distance(inWorld, glm::dvec3(x[i] + 10, y[i], z[i])), 1e-5) << "point " << i;
    }
}

// Scanners that begin with the sky write more records than a block holds before the first that is valid.
TEST_F(E57, WhatIsInvalidDecidesNeitherTheOriginNorTheColours) {
    constexpr std::size_t kSky = 70000, kPoints = 100;
    const glm::dvec3 grid(683123.0, 5247456.0, 412.0);
    std::vector<double> x(kSky, 0.0), y(kSky, 0.0), z(kSky, 0.0), invalid(kSky, 2.0), red(kSky, 65535.0);
    std::vector<double> noColour(kSky, 0.0);
    for (std::size_t i = 0; i < kPoints; ++i) {
        const double step = static_cast<double>(i);
        x.push_back(grid.x + 0.0001 * step), y.push_back(grid.y - 5 + 0.1 * step), z.push_back(grid.z + 0.01 * step);
        invalid.push_back(0);
        red.push_back(i == 0 ? 60000 : 102); // of the first it is said that it is none
        noColour.push_back(i == 0);
    }
    red.back() = 255;
    WrittenScan written{"sky", {}, cartesian(x, y, z)};
    written.fields.push_back({"cartesianInvalidState", NumberType::integer, invalid, 0, 2});
    for (const char* name : {"colorRed", "colorGreen", "colorBlue"})
        written.fields.push_back({name, NumberType::float32, red});
    written.fields.push_back({"isColorInvalid", NumberType::integer, noColour, 0, 1});
    const Scan scan = readOne(written);
    ASSERT_EQ(scan.pointsInScanner.size(), kPoints);
    EXPECT_EQ(scan.invalidPoints, std::int64_t{kSky});
    for (std::size_t i = 0; i < kPoints; ++i) {
        const glm::dvec3 inWorld = scan.worldFromScanner * glm::dvec3(scan.pointsInScanner[i]);
        EXPECT_LT(glm::distance(inWorld, glm::dvec3(x[kSky + i], y[kSky + i], z[kSky + i])), 1e-5) << "point " << i;
    }
    EXPECT_EQ(scan.colours[0], (Rgb8{128, 128, 128}));
    EXPECT_EQ(scan.colours[1], (Rgb8{102, 102, 102})) << "bytes, not 16 bit numbers";
}

TEST_F(E57, FarPointsOfAScannerStayAboutIt) {
    std::vector<double> x, y, z;
    for (int i = 0; i < 100; ++i)
        x.push_back(1500 + 20 * i), y.push_back(1000 - 20 * i), z.push_back(i);
    const Scan scan = readOne({"ridge", {}, cartesian(x, y, z)});
    EXPECT_EQ(scan.worldFromScanner.translation, glm::dvec3(0.0));
}

TEST_F(E57, ManyPointsComeBlockByBlock) {
    std::vector<double> x(200000), y(x.size(), 1.0), z(x.size(), 2.0);
    for (std::size_t i = 0; i < x.size(); ++i)
        x[i] = static_cast<double>(i);
    const Scan scan = readOne({"many", {}, cartesian(x, y, z)});
    ASSERT_EQ(scan.pointsInScanner.size(), x.size());
    for (std::size_t i = 0; i < x.size(); i += 777)
        EXPECT_EQ(scan.pointsInScanner[i].x, static_cast<float>(i));
}

TEST_F(E57, WhatCannotBeUsedIsRemarkedOn) {
    writeE57(folder_ / "a.e57", {{"bare", {}, {{"intensity", NumberType::float32, {1, 2}}}}});
    EXPECT_TRUE(list().empty());
    ASSERT_FALSE(remarks_.empty());
    EXPECT_NE(remarks_[0].find("'bare' without coordinates"), std::string::npos) << remarks_[0];
}

TEST_F(E57, EmbeddedImagesTellKindPoseAndCamera) {
    cv::Mat picture(40, 60, CV_8UC3, cv::Scalar(10, 20, 200)); // blue, green, red
    std::vector<std::uint8_t> jpeg;
    ASSERT_TRUE(cv::imencode(".jpg", picture, jpeg));
    const std::vector<WrittenNumber> size{{"imageWidth", 60}, {"imageHeight", 40}};
    auto pinhole = size, sphere = size;
    pinhole.insert(pinhole.end(), {{"focalLength", 0.02},
                                   {"pixelWidth", 0.0005},
                                   {"pixelHeight", 0.0004},
                                   {"principalPointX", 30.5},
                                   {"principalPointY", 19.5}});
    sphere.insert(sphere.end(), {{"pixelWidth", 0.1}, {"pixelHeight", 0.05}});
    writeE57(folder_ / "a.e57", {{"scan", {}, cartesian({1}, {0}, {0})}},
             {{"camera", "pinholeRepresentation", WrittenPose{1, 0, 0, 0, 1, 2, 3}, pinhole, jpeg},
              {"sphere", "sphericalRepresentation", WrittenPose{}, sphere, jpeg},
              {"tube", "cylindricalRepresentation", {}, size, jpeg},
              {"look", "visualReferenceRepresentation", {}, size, {1, 2, 3, 4}}});
    const auto images = listE57Images(folder_ / "a.e57");
    ASSERT_EQ(images.size(), 4u);
    EXPECT_EQ(images[0].kind, E57ImageKind::pinhole);
    EXPECT_TRUE(images[0].hasPose);
    EXPECT_EQ(images[0].width, 60);
    EXPECT_NEAR(images[0].camera.fx, 40, 1e-9);
    EXPECT_NEAR(images[0].camera.fy, 50, 1e-9);
    EXPECT_EQ(images[0].camera.cx, 30.5);
    // E57's cameras look along -Z with Y up.
    EXPECT_LT(glm::distance(images[0].worldFromCamera * glm::dvec3(0, 0, 1), glm::dvec3(1, 2, 2)), 1e-12);
    EXPECT_LT(glm::distance(images[0].worldFromCamera * glm::dvec3(0, 1, 0), glm::dvec3(1, 1, 3)), 1e-12);
    EXPECT_EQ(images[1].kind, E57ImageKind::spherical);
    EXPECT_EQ(images[1].pixelHeightRadians, 0.05);
    EXPECT_EQ(images[2].kind, E57ImageKind::cylindrical);
    EXPECT_FALSE(images[2].hasPose);
    EXPECT_EQ(images[3].kind, E57ImageKind::visualReference);
    EXPECT_EQ(readE57ImageBytes(images[0]), jpeg);
    const Image<Rgb8> decoded = readE57Image(images[0]);
    ASSERT_EQ(decoded.width(), 60);
    EXPECT_NEAR(decoded(5, 5).r, 200, 3);
    EXPECT_NEAR(decoded(5, 5).b, 10, 3);
    EXPECT_THROW(readE57Image(images[3]), Failure) << "four bytes are no picture";
}

} // namespace
} // namespace scene
