#include "app/plan_picture.h"

#include "scene/errors.h"
#include "scene/picture_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include <tbb/parallel_for.h>

namespace app {

namespace {

constexpr int kLongSide = 1100, kMargin = 40, kFoot = 62, kLeastWidth = 860; // pixels
constexpr int kHeights = 28;
constexpr double kFromMetres = 0.3, kToMetres = 2.0; ///< above the floor: what a person would walk through
const cv::Scalar kInk(50, 42, 38), kPaper(255, 255, 255), kBefore(150, 84, 24), kNext(40, 40, 205);
const cv::Vec3d kEmptyColour(236, 244, 247), kSurfaceColour(60, 52, 46), kUnseenColour(104, 172, 246);

/// The ground from above: pixel = (right, down) of metres in the plan's own axes.
struct Sheet {
    scene::Pose planFromWorld; ///< x right, z down the page, y up
    glm::dvec3 size{0.0};
    double pixelsPerMetre = 1, border = 0; ///< metres about the bounds
    int left = kMargin;
    cv::Point2d at(const glm::dvec3& pInWorld) const {
        const glm::dvec3 p = planFromWorld * pInWorld;
        return {left + p.x * pixelsPerMetre, kMargin + p.z * pixelsPerMetre};
    }
};

scene::Pose aboutUp(int quarters, const glm::dvec3& size) {
    // A quarter turn about y carries (x, z) to (z, -x); the box's corner stays at the origin.
    scene::Pose pose;
    glm::dvec3 extent = size;
    for (int i = 0; i < quarters; ++i) {
        const scene::Pose quarter{glm::dmat3(0, 0, -1, 0, 1, 0, 1, 0, 0), glm::dvec3(0, 0, extent.x)};
        pose = quarter * pose;
        std::swap(extent.x, extent.z);
    }
    return pose;
}

Sheet layOut(const scene::Scene& scene, const scene::NextScanPlan& plan) {
    const scene::Pose worldFromWalk = inverse(scene.walkFromWorld);
    Sheet sheet;
    double best = -2;
    for (int quarters = 0; quarters < 4; ++quarters) {
        const scene::Pose planFromWorld = aboutUp(quarters, plan.bounds.size) * plan.bounds.boundsFromWorld;
        const glm::dvec3 ahead = planFromWorld.rotation * (worldFromWalk.rotation * glm::dvec3(0, 0, -1));
        if (-ahead.z <= best + 1e-9) continue;
        best = -ahead.z;
        sheet.planFromWorld = planFromWorld;
        sheet.size = plan.bounds.size;
        if (quarters % 2 == 1) std::swap(sheet.size.x, sheet.size.z);
    }
    // Walls stand just outside of what was seen empty.
    const double border = 0.02 * std::max(sheet.size.x, sheet.size.z);
    sheet.planFromWorld.translation += glm::dvec3(border, 0, border);
    sheet.size += glm::dvec3(2 * border, 0, 2 * border);
    sheet.border = border;
    sheet.pixelsPerMetre = kLongSide / std::max({sheet.size.x, sheet.size.z, 1e-3});
    return sheet;
}

/// Columns of space between ankle and head, seen from above.
void shadeGround(cv::Mat3b& picture, const Sheet& sheet, const scene::Scene& scene) {
    const scene::Pose worldFromPlan = inverse(sheet.planFromWorld);
    const double floor = (sheet.planFromWorld * (inverse(scene.walkFromWorld) * glm::dvec3(0))).y;
    const int columns = static_cast<int>(sheet.size.x * sheet.pixelsPerMetre);
    const int rows = static_cast<int>(sheet.size.z * sheet.pixelsPerMetre);
    tbb::parallel_for(0, rows, [&](int row) {
        for (int column = 0; column < columns; ++column) {
            std::array<int, 3> count{};
            for (int i = 0; i < kHeights; ++i) {
                const double y = floor + kFromMetres + (kToMetres - kFromMetres) * (i + 0.5) / kHeights;
                const glm::dvec3 p((column + 0.5) / sheet.pixelsPerMetre, y, (row + 0.5) / sheet.pixelsPerMetre);
                ++count[static_cast<std::size_t>(observedAt(*scene.coverage, worldFromPlan * p))];
            }
            const double x = (column + 0.5) / sheet.pixelsPerMetre, z = (row + 0.5) / sheet.pixelsPerMetre;
            const bool counts = x >= sheet.border && z >= sheet.border && x <= sheet.size.x - sheet.border &&
                                z <= sheet.size.z - sheet.border;
            const double unseen = counts ? count[0] / double{kHeights} : 0;
            const double surface = std::min(1.0, 3.0 * count[1] / kHeights);
            const cv::Vec3d ground = !counts && count[2] == 0
                                         ? cv::Vec3d(255, 255, 255)
                                         : kEmptyColour + (kUnseenColour - kEmptyColour) * std::pow(unseen, 0.7);
            const cv::Vec3d colour = ground + (kSurfaceColour - ground) * surface;
            picture(kMargin + row, sheet.left + column) =
                cv::Vec3b(cv::saturate_cast<uchar>(colour[0]), cv::saturate_cast<uchar>(colour[1]),
                          cv::saturate_cast<uchar>(colour[2]));
        }
    });
}

void write(cv::Mat3b& picture, const std::string& text, cv::Point at, double size, const cv::Scalar& colour,
           int thickness = 1) {
    cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, thickness, cv::LINE_AA);
}

/// In tenths of a pixel or so, so that circles are round where they stand.
void disc(cv::Mat3b& picture, const cv::Point2d& at, double radius, const cv::Scalar& colour) {
    constexpr int kShift = 4, kOne = 1 << kShift;
    const cv::Point centre(static_cast<int>(at.x * kOne), static_cast<int>(at.y * kOne));
    cv::circle(picture, centre, static_cast<int>((radius + 2) * kOne), kPaper, cv::FILLED, cv::LINE_AA, kShift);
    cv::circle(picture, centre, static_cast<int>(radius * kOne), colour, cv::FILLED, cv::LINE_AA, kShift);
}

/// Many cameras are dots, few scanners are discs.
double radiusOf(std::size_t count) {
    return count <= 24 ? 8 : 3;
}

void drawScaleBar(cv::Mat3b& picture, const Sheet& sheet, int y) {
    double metres = 1;
    for (const double step : {0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0})
        if (step * sheet.pixelsPerMetre <= 220) metres = step;
    const int length = static_cast<int>(std::lround(metres * sheet.pixelsPerMetre));
    const cv::Point from(kMargin, y);
    cv::rectangle(picture, from, from + cv::Point(length, 7), kInk, 1);
    cv::rectangle(picture, from, from + cv::Point(length / 2, 7), kInk, cv::FILLED);
    char text[32];
    std::snprintf(text, sizeof text, "%g m", metres);
    write(picture, text, from + cv::Point(length + 8, 9), 0.5, kInk);
}

/// The two axes of the world that lie flattest, from above.
void drawAxes(cv::Mat3b& picture, const Sheet& sheet, const cv::Point& origin) {
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 along(0);
        along[axis] = 1;
        const glm::dvec3 p = sheet.planFromWorld.rotation * along;
        if (std::hypot(p.x, p.z) < 0.5) continue;
        const cv::Point tip(origin.x + static_cast<int>(std::lround(26 * p.x)),
                            origin.y + static_cast<int>(std::lround(26 * p.z)));
        cv::arrowedLine(picture, origin, tip, kInk, 1, cv::LINE_AA, 0, 0.25);
        write(picture, std::string(1, "xyz"[axis]),
              cv::Point(origin.x + static_cast<int>(std::lround(36 * p.x)) - 4,
                        origin.y + static_cast<int>(std::lround(36 * p.z)) + 4),
              0.45, kInk);
    }
}

void drawLegend(cv::Mat3b& picture, const Sheet& sheet, int y, std::size_t before) {
    drawScaleBar(picture, sheet, y);
    int x = kMargin;
    const int line = y + 44;
    const auto patch = [&](const cv::Vec3d& colour, const char* text, int width) {
        cv::rectangle(picture, {x, line - 11}, {x + 18, line + 3}, cv::Scalar(colour[0], colour[1], colour[2]),
                      cv::FILLED);
        cv::rectangle(picture, {x, line - 11}, {x + 18, line + 3}, kInk, 1);
        write(picture, text, {x + 26, line + 1}, 0.48, kInk);
        x += width;
    };
    patch(kEmptyColour, "seen empty", 140);
    patch(kSurfaceColour, "surface", 110);
    patch(kUnseenColour, "never observed", 170);
    disc(picture, {x + 8.0, line - 4.0}, std::min(7.0, radiusOf(before)), kBefore);
    write(picture, "stood here", {x + 24, line + 1}, 0.48, kInk);
    disc(picture, {x + 140.0, line - 4.0}, 7, kNext);
    write(picture, "next scan", {x + 156, line + 1}, 0.48, kInk);
    drawAxes(picture, sheet, {picture.cols - kMargin - 44, line - 18});
}

void drawProposals(cv::Mat3b& picture, const Sheet& sheet, const scene::NextScanPlan& plan) {
    for (std::size_t i = plan.scans.size(); i-- > 0;) {
        const cv::Point2d at = sheet.at(plan.scans[i].positionInWorld);
        disc(picture, at, 15, kNext);
        const std::string number = std::to_string(i + 1);
        const double size = number.size() == 1 ? 0.65 : 0.5;
        int baseline = 0;
        const cv::Size box = cv::getTextSize(number, cv::FONT_HERSHEY_SIMPLEX, size, 2, &baseline);
        write(
            picture, number,
            {static_cast<int>(std::lround(at.x)) - box.width / 2, static_cast<int>(std::lround(at.y)) + box.height / 2},
            size, kPaper, 2);
        char share[32];
        std::snprintf(share, sizeof share, "+%.1f %%", 100 * plan.scans[i].revealsShare);
        const cv::Size label = cv::getTextSize(share, cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, &baseline);
        const bool isRight = at.x + 22 + label.width < picture.cols - 4;
        const cv::Point corner(static_cast<int>(at.x) + (isRight ? 21 : -21 - label.width), static_cast<int>(at.y) + 5);
        cv::rectangle(picture, corner + cv::Point(-3, 4), corner + cv::Point(label.width + 3, -label.height - 4),
                      kPaper, cv::FILLED);
        write(picture, share, corner, 0.5, kNext);
    }
}

} // namespace

std::vector<std::byte> drawPlan(const scene::Scene& scene, const scene::NextScanPlan& plan,
                                std::span<const glm::dvec3> stood) {
    cv::Mat3b picture;
    if (plan.bounds.isEmpty()) {
        picture = cv::Mat3b(80, kLeastWidth, cv::Vec3b(255, 255, 255));
        write(picture, "No space was seen empty.", {kMargin, 46}, 0.6, kInk);
    } else {
        Sheet sheet = layOut(scene, plan);
        const int width = static_cast<int>(sheet.size.x * sheet.pixelsPerMetre);
        const int height = static_cast<int>(sheet.size.z * sheet.pixelsPerMetre);
        picture = cv::Mat3b(height + 2 * kMargin + kFoot, std::max(kLeastWidth, width + 2 * kMargin),
                            cv::Vec3b(255, 255, 255));
        sheet.left = (picture.cols - width) / 2;
        shadeGround(picture, sheet, scene);
        cv::rectangle(picture, {sheet.left - 1, kMargin - 1}, {sheet.left + width, kMargin + height}, kInk, 1);
        for (const glm::dvec3& place : stood)
            disc(picture, sheet.at(place), radiusOf(stood.size()), kBefore);
        drawProposals(picture, sheet, plan);
        drawLegend(picture, sheet, height + kMargin + 26, stood.size());
    }
    const std::vector<std::uint8_t> bytes = scene::encodePng(picture);
    if (bytes.empty())
        throw scene::Failure("cannot be encoded", std::string("the picture of the plan"),
                             "tell us: it should not happen");
    const auto encoded = std::as_bytes(std::span(bytes));
    return {encoded.begin(), encoded.end()};
}

} // namespace app
