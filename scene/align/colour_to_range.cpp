#include "scene/align/colour_to_range.h"

#include "scene/align/turn_search.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace scene {

namespace {

constexpr double kBroadestSigma = 0.5 * kDegree;       ///< of the levels, in the middle of the picture
constexpr double kMostDeviationFound = 0.25 * kDegree; ///< beyond, a top is no place but a ridge
constexpr double kFinestSigmaPixels = 1.2;
constexpr std::size_t kMostLevels = 5;
constexpr int kMostRays = 14400;

/// ": to 0.12 degrees"; nothing where it is not known at all.
std::string knownTo(double radians) {
    std::array<char, 48> text{};
    if (std::isfinite(radians)) std::snprintf(text.data(), text.size(), ": to %.2f degrees", radians / kDegree);
    return text.data();
}

PartRays raysOf(const EdgeImage& edges, const Camera& camera) {
    PartRays parts;
    // Each part in four by four, so that edges of one window do not stand for all of it.
    for (const EdgePoint& point : edgePoints(edges, 4 * kPartColumns, 4 * kPartRows, kMostRays / (16 * kParts))) {
        const int column = std::min(static_cast<int>(point.x) * kPartColumns / edges.width(), kPartColumns - 1),
                  row = std::min(static_cast<int>(point.y) * kPartRows / edges.height(), kPartRows - 1);
        parts[static_cast<std::size_t>(row * kPartColumns + column)].push_back(
            {glm::vec3(rayThrough(camera, point.x, point.y)), point.strength, point.cosine, point.sine});
    }
    return parts;
}

} // namespace

void judge(ColourFit& fit, const ColourToRangeOptions& options) {
    fit.why.clear();
    const double leastAgreeing =
        fit.rivalShare <= options.mostRivalShareAlone ? options.leastAgreeingAlone : options.leastAgreeing;
    if (fit.parts < options.leastParts)
        fit.why = "too little of it has edges";
    else if (fit.rivalShare > options.mostRivalShare)
        fit.why = "other turns fit nearly as well";
    else if (fit.score < options.leastScore)
        fit.why = "its edges do not lie on those of the scan";
    else if (fit.agreeing < leastAgreeing)
        fit.why = "most parts of it fit other turns better";
    else if (!(fit.turnedRadians <= options.reachRadians))
        fit.why = "the best turn is beyond what was looked through";
    fit.isFound = fit.why.empty() && fit.deviationRadians <= kMostDeviationFound;
    if (fit.why.empty() && !(fit.deviationRadians <= options.mostDeviationRadians))
        fit.why = "its edges do not say exactly enough how it is turned" + knownTo(fit.deviationRadians);
    fit.isSure = fit.why.empty();
}

Camera widened(const Camera& camera, double reachRadians, double pixelRadians) {
    const double scaleX = 1 / (pixelRadians * camera.fx), scaleY = 1 / (pixelRadians * camera.fy);
    const auto edge = [&](double tangent) { // of an edge's angle from the axis, turned outwards
        return std::tan(std::min(std::atan(tangent) + 1.1 * reachRadians, 1.45));
    };
    const double corner = std::max(camera.cx, camera.width - camera.cx) / camera.fx; // a roll lifts corners
    const double corner2 = std::max(camera.cy, camera.height - camera.cy) / camera.fy;
    const double left = edge(camera.cx / camera.fx + corner2 * reachRadians),
                 right = edge((camera.width - camera.cx) / camera.fx + corner2 * reachRadians);
    const double up = edge(camera.cy / camera.fy + corner * reachRadians),
                 down = edge((camera.height - camera.cy) / camera.fy + corner * reachRadians);
    Camera wide;
    wide.fx = camera.fx * scaleX, wide.fy = camera.fy * scaleY;
    wide.cx = std::ceil(left * wide.fx), wide.cy = std::ceil(up * wide.fy);
    wide.width = static_cast<int>(wide.cx + std::ceil(right * wide.fx));
    wide.height = static_cast<int>(wide.cy + std::ceil(down * wide.fy));
    return wide;
}

std::vector<EdgeLevel> edgeLevels(const EdgeImage& edges, const EdgeImage& fineEdges, double pixelRadians) {
    std::vector<double> sigmas;
    for (double sigma = kBroadestSigma / pixelRadians;
         sigma > kFinestSigmaPixels * 1.2 && sigmas.size() + 1 < kMostLevels; sigma /= 2)
        sigmas.push_back(sigma);
    sigmas.push_back(kFinestSigmaPixels);
    std::vector<EdgeLevel> levels;
    for (const double sigma : sigmas)
        levels.push_back(blurredEdges(levels.size() + 2 < sigmas.size() ? edges : fineEdges, sigma));
    return levels;
}

ColourFit findTurn(const DepthImage& scan, const Image<Rgb8>& photograph, const Camera& camera,
                   const ColourToRangeOptions& options) {
    assert(photograph.width() == camera.width && photograph.height() == camera.height);
    const EdgeImage edges = scanEdges(scan);
    const std::vector<EdgeLevel> levels = edgeLevels(edges, withoutOpenRims(edges, scan), 1 / scan.camera.fx);
    const TurnFound found =
        TurnSearch(levels, scan.camera, raysOf(photographEdges(photograph), camera)).find(options.reachRadians);
    ColourFit fit;
    fit.givenFromFound = matrixOf(found.turn);
    fit.turnedRadians = found.turn.norm();
    const Eigen::Matrix3d covariance =
        found.covariance.value_or(Eigen::Matrix3d::Identity()) +
        options.leastDeviationRadians * options.leastDeviationRadians * Eigen::Matrix3d::Identity();
    for (int i = 0; i < 9; ++i)
        fit.covariance[i / 3][i % 3] = covariance(i % 3, i / 3);
    fit.deviationRadians = std::sqrt(covariance.trace());
    fit.score = found.score;
    fit.rivalShare = found.rivalShare;
    fit.agreeing = found.agreeing;
    fit.parts = found.parts;
    judge(fit, options);
    return fit;
}

} // namespace scene
