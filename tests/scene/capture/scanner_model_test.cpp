// The scanner's geometry against closed forms, and against reflection at a mirror as vectors have it.

#include "scene/scanner_model.h"
#include "scene/synthetic_random.h"

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec3.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

constexpr double kPi = std::numbers::pi;

glm::dvec3 beam(const ScannerConstants<double>& constants, double encoder, double pan) {
    const auto d = beamDirection(constants, encoder, pan);
    return {d[0], d[1], d[2]};
}

void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
    EXPECT_LT(glm::distance(a, b), tolerance) << a.x << ' ' << a.y << ' ' << a.z;
}

TEST(ScannerModel, APerfectMirrorSweepsThePlaneAcrossTheShaft) {
    const ScannerConstants<double> nominal;
    expectNear(beam(nominal, 0, 0), {1, 0, 0}, 1e-12);
    expectNear(beam(nominal, 1024, 0), {0, 0, 1}, 1e-12);
    expectNear(beam(nominal, 2048, 0), {-1, 0, 0}, 1e-12);
    expectNear(beam(nominal, 0, 7000), {0, 1, 0}, 1e-12); // a quarter turn of the pan unit
    expectNear(beam(nominal, 512, 14000), {-std::sqrt(0.5), 0, std::sqrt(0.5)}, 1e-12);
}

TEST(ScannerModel, TheBeamIsTheShaftsReflection) {
    SeededSequence chance(5);
    for (int i = 0; i < 1000; ++i) {
        ScannerConstants<double> c;
        c.mirrorRadians = chance.between(0.6, 1.0);
        c.horizonPosition = chance.between(0, 4096);
        c.panStepsPerHalfTurn = chance.between(13000, 15000);
        const double encoder = chance.between(0, 4096), pan = chance.between(-20000, 20000);
        const double turn = (encoder - c.horizonPosition) * 2 * kPi / 4096, azimuth = pan * kPi / c.panStepsPerHalfTurn;
        const glm::dvec3 level(std::cos(azimuth), std::sin(azimuth), 0),
            shaft(-std::sin(azimuth), std::cos(azimuth), 0);
        const glm::dvec3 out = std::cos(turn) * level + std::sin(turn) * glm::dvec3(0, 0, 1);
        // The mirror faces back to the laser and outwards.
        const glm::dvec3 normal = -std::cos(c.mirrorRadians) * shaft + std::sin(c.mirrorRadians) * out;
        expectNear(beam(c, encoder, pan), shaft - 2 * glm::dot(shaft, normal) * normal, 1e-12);
    }
}

TEST(ScannerModel, TheErrorsThatThePaperFoundComeToCentimetresAtThreeMetres) {
    ScannerConstants<double> found;
    found.panStepsPerHalfTurn = 14039;
    found.mirrorRadians = glm::radians(44.8);
    const ScannerConstants<double> nominal;
    // A fifth of a degree of the mirror is two fifths of the beam, level or not; 39 steps are half a degree at the end.
    EXPECT_NEAR(glm::distance(beam(found, 0, 0), beam(nominal, 0, 0)) * 3, 3 * glm::radians(0.4), 1e-5);
    const double end = glm::distance(beam(found, 0, 14000), beam(nominal, 0, 14000)) * 3;
    EXPECT_GT(end, 0.003);
    EXPECT_LT(end, 0.05);
}

TEST(ScannerModel, TurningOverTheZenithMirrorsWhatALeaningMirrorGetsWrong) {
    // One and the same place is seen by both faces of the pan range: their errors along the shaft are opposite.
    ScannerConstants<double> leaning;
    leaning.mirrorRadians = glm::radians(44.8);
    const glm::dvec3 front = beam(leaning, 300, 0), back = beam(leaning, 2048 - 300, 14000);
    EXPECT_NEAR(front.x, back.x, 1e-12);
    EXPECT_NEAR(front.z, back.z, 1e-12);
    EXPECT_NEAR(front.y, -back.y, 1e-12);
    EXPECT_GT(std::abs(front.y), 0.006);
}

TEST(ScannerModel, RangeIsCountedByWayOfTheMirror) {
    ScannerConstants<double> constants;
    constants.mirrorMetres = 0.25;
    const auto p = scannedPoint<double>(constants, 1024, 123, 2.25);
    expectNear({p[0], p[1], p[2]}, {0, 0, 2}, 1e-12);
}

} // namespace
} // namespace scene
