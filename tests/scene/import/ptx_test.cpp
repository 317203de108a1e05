// PTX as its writers write it, and as nobody should.

#include "scene/import/ptx.h"

#include "scene/errors.h"
#include "tests/repetitions.h"
#include "tests/scene/import/written_e57.h"

#include <chrono>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <sys/resource.h>

namespace scene {
namespace {

const std::string kAtHome = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
// A quarter turn about Z and a move, for row vectors: p M, the translation last.
const std::string kTurned = "4 5 6\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n4 5 6 1\n";

class Ptx : public testing::Test {
  protected:
    std::filesystem::path file(const std::string& text) {
        writeBytes(folder_ / "a.ptx", text);
        return folder_ / "a.ptx";
    }
    Scan readOne(const std::string& text) { return readPtxScan(listPtx(file(text), remarks_).at(0)); }
    std::string failureOf(const std::filesystem::path& path) {
        try {
            for (const ScanSource& source : listPtx(path, remarks_)) {
                const Scan scan = readPtxScan(source);
                EXPECT_EQ(scan.colours.size(), scan.pointsInScanner.size());
            }
        } catch (const Failure& failure) {
            const std::string message = failure.what();
            EXPECT_EQ(message.find(path.string()), 0u) << message;
            return message;
        }
        return {};
    }
    void expectRefused(const std::string& text, const std::string& words) {
        const std::string message = failureOf(file(text));
        EXPECT_NE(message.find(words), std::string::npos) << "'" << message << "' does not say '" << words << "'";
    }

    TemporaryFolder folder_;
    std::vector<std::string> remarks_;
};

TEST_F(Ptx, PointsStandColumnByColumn) {
    const Scan scan =
        readOne("2\n3\n" + kAtHome + "1 0 0 0.5\n2 0 0 0.5\n3 0 0 0.5\n4 0 0 0.5\n0 0 0 0.5\n6 0 0 1.0\n");
    EXPECT_EQ(scan.name, "a");
    EXPECT_EQ(scan.rows, 3);
    EXPECT_EQ(scan.columns, 2);
    ASSERT_EQ(scan.pointsInScanner.size(), 5u) << "0 0 0 is no return";
    EXPECT_EQ(scan.invalidPoints, 0);
    EXPECT_EQ(scan.row, (std::vector<std::int32_t>{0, 1, 2, 0, 2}));
    EXPECT_EQ(scan.column, (std::vector<std::int32_t>{0, 0, 0, 1, 1}));
    EXPECT_FALSE(scan.hasColour);
    EXPECT_EQ(scan.colours[0], (Rgb8{128, 128, 128}));
    EXPECT_EQ(scan.colours[4], (Rgb8{255, 255, 255}));
}

TEST_F(Ptx, LinesWithoutColourAreAsBrightAsWhatCameBack) {
    const Scan scan = readOne("1\n3\n" + kAtHome + "1 0 0 0.5 10 20 30\n2 0 0 1.0\n3 0 0 40 50 60\n");
    EXPECT_TRUE(scan.hasColour);
    EXPECT_EQ(scan.isColoured, (std::vector<bool>{true, false, true}));
    EXPECT_EQ(scan.colours, (std::vector<Rgb8>{{10, 20, 30}, {255, 255, 255}, {40, 50, 60}}));
}

TEST_F(Ptx, TheTranslationIsTheLastRow) {
    const Scan scan = readOne("1\n1\n" + kTurned + "1 0 0 0.5 10 20 30\n");
    EXPECT_TRUE(scan.hasColour);
    EXPECT_EQ(scan.colours[0], (Rgb8{10, 20, 30}));
    EXPECT_LT(glm::distance(scan.worldFromScanner * glm::dvec3(scan.pointsInScanner[0]), glm::dvec3(4, 6, 6)), 1e-9);
}

TEST_F(Ptx, SeveralCloudsAndTheirPlaces) {
    const std::string text = "1\n2\n" + kAtHome + "1 0 0\r\n2 0 0\r\n" + "\n1\n1\n" + kTurned + "7 0 0 0.1 1 2 3";
    const auto sources = listPtx(file(text), remarks_);
    ASSERT_EQ(sources.size(), 2u);
    EXPECT_EQ(sources[0].name, "a-1");
    EXPECT_EQ(sources[1].name, "a-2");
    EXPECT_EQ(sources[0].pointCount, 2);
    const Scan second = readPtxScan(sources[1]);
    ASSERT_EQ(second.pointsInScanner.size(), 1u);
    EXPECT_EQ(second.pointsInScanner[0].x, 7.0f);
    EXPECT_EQ(readPtxScan(sources[0]).pointsInScanner[1].x, 2.0f);
}

TEST_F(Ptx, PointsThatAreInTheWorldAlreadyComeBackAboutTheScanner) {
    const Scan scan = readOne("1\n2\n100 200 10\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
                              "101 200 10 0.5\n100 202 10 0.5\n");
    EXPECT_EQ(scan.pointsInScanner[0], glm::vec3(1, 0, 0));
    EXPECT_EQ(scan.worldFromScanner * glm::dvec3(0.0), glm::dvec3(100, 200, 10));
}

TEST_F(Ptx, AUniformScaleIsTakenIntoThePoints) {
    const Scan scan = readOne("1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0.001 0 0 0\n0 0.001 0 0\n0 0 0.001 0\n0 0 0 1\n"
                              "1500 0 0 0.5\n");
    EXPECT_FLOAT_EQ(scan.pointsInScanner[0].x, 1.5f);
}

TEST_F(Ptx, AScaleIsToldOfWhetherItIsAppliedOrNot) {
    const auto cloudOf = [](const std::string& scale) {
        return "1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n" + scale + " 0 0 0\n0 " + scale + " 0 0\n0 0 " + scale +
               " 0\n0 0 0 1\n2 0 0 0.5\n";
    };
    const auto expectTold = [&](const std::string& text, float x, const std::vector<std::string>& told) {
        remarks_.clear();
        EXPECT_FLOAT_EQ(readOne(text).pointsInScanner[0].x, x) << text;
        ASSERT_EQ(remarks_.size(), told.size()) << text;
        for (std::size_t i = 0; i < told.size(); ++i)
            EXPECT_EQ(remarks_[i], (folder_ / "a.ptx").string() + ": " + told[i]);
    };
    const std::string leftAsTheyAre = "; that may be rounding, and its points were left as they are.";
    expectTold(cloudOf("1"), 2, {});
    expectTold(cloudOf("1.000001"), 2, {});
    expectTold(cloudOf("1.0015"), 2, {"the transform of cloud 1 scales it by 1.0015" + leftAsTheyAre});
    expectTold(cloudOf("0.99985"), 2, {"the transform of cloud 1 scales it by 0.99985" + leftAsTheyAre});
    expectTold(cloudOf("1.0025"), 2.005f, {"the transform of cloud 1 scales it by 1.0025; its points were scaled."});
    expectTold(cloudOf("0.001") + cloudOf("1.0005") + cloudOf("0.002") + cloudOf("1"), 0.002f,
               {"the transform of cloud 1 scales it by 0.001, those of 1 more scale, too; its points were scaled.",
                "the transform of cloud 2 scales it by 1.0005" + leftAsTheyAre});
}

TEST_F(Ptx, NationalGridOffsetsKeepTheirAccuracy) {
    const Scan scan = readOne("1\n3\n" + kAtHome +
                              "683123.1234 5247456.5678 412.0001 0.5\n683124.2345 5247457.6789 413.5 0.5\n"
                              "683125.3456 5247455.1 411.25 0.5\n");
    const glm::dvec3 inWorld = scan.worldFromScanner * glm::dvec3(scan.pointsInScanner[0]);
    EXPECT_LT(glm::distance(inWorld, glm::dvec3(683123.1234, 5247456.5678, 412.0001)), 1e-5);
    EXPECT_EQ(scan.rows, 0) << "the grid's angles were about a scanner that the file does not place";
}

TEST_F(Ptx, NonFinitePointsAreCounted) {
    const Scan scan = readOne("1\n3\n" + kAtHome + "nan 0 0 0.5\n1 2 3 0.5\n1e300 0 0 0.5\n");
    EXPECT_EQ(scan.pointsInScanner.size(), 1u);
    EXPECT_EQ(scan.invalidPoints, 2);
}

TEST_F(Ptx, IntensityBeyondOneIsScaledByWhatWasObserved) {
    const Scan scan = readOne("1\n3\n" + kAtHome + "1 0 0 0\n2 0 0 100\n3 0 0 200\n");
    EXPECT_EQ(scan.colours[1].r, 128);
    EXPECT_EQ(scan.colours[2].r, 255);
}

TEST_F(Ptx, RefusalsNameFileLineAndCause) {
    expectRefused("", "is empty");
    expectRefused("\n\n", "is empty");
    EXPECT_NE(failureOf(folder_ / "none.ptx").find("is not there"), std::string::npos);
    EXPECT_NE(failureOf(folder_ / "").find("is not a file"), std::string::npos);
    expectRefused("hello\n", "line 1: should hold the number of columns");
    expectRefused("-1\n2\n" + kAtHome, "number of columns");
    expectRefused("1.5\n2\n" + kAtHome, "number of columns");
    expectRefused("2\n99999999999\n" + kAtHome, "number of rows");
    expectRefused("2\n2\n0 0 0\n", "ends within the header");
    expectRefused("1\n1\n0 0 nan\n", "line 3: should hold 3 finite numbers");
    expectRefused("1\n1\n" + replaced(kAtHome, "1 0 0 0\n", "nan 0 0 0\n") + "1 0 0\n", "line 7");
    expectRefused("1\n1\n" + replaced(kAtHome, "0 0 1 0\n", "0 0 2 0\n") + "1 0 0\n", "line 10: the transform");
    expectRefused("1\n1\n" + replaced(kAtHome, "0 0 1 0\n", "0 0 -1 0\n") + "1 0 0\n", "the transform");
    expectRefused("1\n1\n" + replaced(kAtHome, "1 0 0 0\n", "0 0 0 0\n") + "1 0 0\n", "the transform");
    expectRefused("1\n2\n" + kAtHome + "1 0 0 0.5\n1 0 x 0.5\n", "a.ptx");
    expectRefused("1\n2\n" + kAtHome + "1,0 2,0 3,0 0.5\n1 0 0 0.5\n", "should hold x y z");
    expectRefused("1\n2\n" + kAtHome + "1 0 0 0.5 1 2 3 4\n1 0 0 0.5\n", "should hold x y z");
    expectRefused("1\n2\n" + kAtHome + "1 0 0 0.5 blah\n1 0 0 0.5\n", "should hold x y z");
    expectRefused("1\n3\n" + kAtHome + "1 0 0 0.5\n1 0 0 0.5\n", "ends after 2 of the 3 points");
    expectRefused("1000000\n1000000\n" + kAtHome + "1 0 0 0.5\n", "claims 1000000000000 points");
    expectRefused(std::string(200000, 'x'), "not text");
    expectRefused(std::string(200000, '\0'), "not text");
}

TEST_F(Ptx, ALargeClaimTakesNoMemory) {
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    expectRefused("2000000000\n2000000000\n" + kAtHome + "1 0 0 0.5\n", "claims");
    getrusage(RUSAGE_SELF, &after);
    EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 100 * 1024) << "kilobytes";
}

TEST_F(Ptx, CutsAndFlipsAreReadOrRefused) {
    std::string text = "3\n20\n" + kTurned;
    for (int i = 0; i < 60; ++i)
        text += std::to_string(i * 0.25) + " 1.5 -2.25 0.75 12 255 0\n";
    for (std::size_t length = 0; length + 30 < text.size(); length += 7)
        EXPECT_NE(failureOf(file(text.substr(0, length))), "") << "cut to " << length;
    std::mt19937 random(3);
    for (int i = 0; i < 500; ++i) {
        std::string damaged = text;
        const std::size_t bit = random() % ((i % 2 ? text.size() : 120) * 8);
        damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
        failureOf(file(damaged));
    }
}

TEST_F(Ptx, AMillionPointsTakeAboutASecondAtMost) {
    constexpr int kPoints = 1000 * tests::repetitions(1000);
    std::string text = std::to_string(kPoints / 1000) + "\n1000\n" + kAtHome;
    for (int i = 0; i < kPoints; ++i)
        text +=
            std::to_string(1 + i % 997 * 0.01) + " " + std::to_string(i % 89 * 0.1) + " 2.250000 0.501961 12 255 77\n";
    const auto path = file(text);
    const auto start = std::chrono::steady_clock::now();
    const Scan scan = readPtxScan(listPtx(path, remarks_).at(0));
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(scan.pointsInScanner.size(), std::size_t{kPoints});
    RecordProperty("seconds", std::to_string(taken.count()));
    EXPECT_LT(taken.count(), 20.0) << "far above what sanitizers and a busy machine need";
}

} // namespace
} // namespace scene
