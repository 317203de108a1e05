#include "scene/project/open_sky.h"

#include "scene/median.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kAsked = 1024;           ///< of a row's or a column's cells, at most
constexpr std::size_t kLeastLines = 8; ///< rows and columns whose angles are known
constexpr double kMostOff = 2.5;       ///< cells, by which nine in ten of those angles may leave the even ones
constexpr int kDirectionStride = 4;    ///< cells
constexpr double kBelow = -0.05;       ///< no cell that may be open looks so far below the horizon, coarse as it is
constexpr double kLeastUpright = 0.7;  ///< cosine of how far a scanner that stands may lean

/// The angle within half a period of another.
double near(double angle, double other, double period) {
    return angle - period * std::round((angle - other) / period);
}

/// Angles of some cells, ascending by cell; an angle means the same as one a period more.
struct Known {
    std::vector<double> cells, angles;
};

/// The even angles that go through them; nothing if they are not even, or too few.
template <class Even>
bool fit(Known known, double period, Even& even) {
    const std::size_t count = known.cells.size();
    if (count < kLeastLines) return false;
    std::vector<double> slopes;
    for (std::size_t i = 1; i < count; ++i) {
        known.angles[i] = near(known.angles[i], known.angles[i - 1], period);
        slopes.push_back((known.angles[i] - known.angles[i - 1]) / (known.cells[i] - known.cells[i - 1]));
    }
    // From cell to cell noise counts most: over as many as there are, what is left of it hardly does.
    const double rough = medianOf(slopes);
    const double middle = known.cells[count / 2];
    for (std::size_t i = 0; i < count; ++i)
        known.angles[i] = near(known.angles[i], known.angles[count / 2] + rough * (known.cells[i] - middle), period);
    const auto slopeBetween = [&](std::size_t i, std::size_t j) {
        return (known.angles[j] - known.angles[i]) / (known.cells[j] - known.cells[i]);
    };
    slopes.clear();
    for (std::size_t i = 0; i + count / 2 < count; ++i)
        slopes.push_back(slopeBetween(i, i + count / 2));
    even.step = medianOf(slopes);
    std::vector<double> firsts, off;
    for (std::size_t i = 0; i < count; ++i)
        firsts.push_back(known.angles[i] - even.step * known.cells[i]);
    even.first = medianOf(firsts);
    for (std::size_t i = 0; i < count; ++i)
        off.push_back(std::abs(known.angles[i] - even.at(known.cells[i])));
    std::sort(off.begin(), off.end());
    return even.step != 0 && off[(count - 1) * 9 / 10] <= kMostOff * std::abs(even.step);
}

/// Each mark combined with those of its eight neighbours. Rows go on at their other end where the grid closes; beyond
/// its other borders there is nothing to combine with.
template <class Combine>
Image<std::uint8_t> ofNeighbourhoods(const Image<std::uint8_t>& marks, bool closes, Combine combine) {
    const int width = marks.width(), height = marks.height();
    Image<std::uint8_t> result(width, height, 0);
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            std::uint8_t value = marks(x, y);
            for (int j = std::max(y - 1, 0); j <= std::min(y + 1, height - 1); ++j)
                for (int i = x - 1; i <= x + 1; ++i) {
                    const int at = closes ? (i + width) % width : std::clamp(i, 0, width - 1);
                    value = combine(value, marks(at, j));
                }
            result(x, y) = value;
        }
    });
    return result;
}

} // namespace

OpenSky::OpenSky(const Scan& scan, const ScanGrid& grid) : closes_(grid.closes) {
    if (findDirections(scan, grid)) findOpen(scan, grid);
}

bool OpenSky::findDirections(const Scan& scan, const ScanGrid& grid) {
    const Image<std::int32_t>& cells = grid.pointOfCell;
    const int strideX = std::max(1, cells.width() / kAsked), strideY = std::max(1, cells.height() / kAsked);
    // A column's points stand in an upright plane, which twice their azimuth tells, on whichever side of the zenith.
    Known turns;
    for (int x = 0; x < cells.width(); x += strideX) {
        double cosine = 0, sine = 0;
        for (int y = 0; y < cells.height(); y += strideY) {
            if (cells(x, y) < 0) continue;
            const glm::dvec3 p =
                glm::normalize(glm::dvec3(scan.pointsInScanner[static_cast<std::size_t>(cells(x, y))]));
            cosine += p.x * p.x - p.y * p.y, sine += 2 * p.x * p.y;
        }
        if (cosine == 0 && sine == 0) continue;
        turns.cells.push_back(x), turns.angles.push_back(0.5 * std::atan2(sine, cosine));
    }
    if (!fit(std::move(turns), kPi, turn_)) return false;
    Known nods;
    std::vector<double> ofRow;
    for (int y = 0; y < cells.height(); y += strideY) {
        ofRow.clear();
        for (int x = 0; x < cells.width(); x += strideX) {
            if (cells(x, y) < 0) continue;
            const glm::dvec3 p(scan.pointsInScanner[static_cast<std::size_t>(cells(x, y))]);
            const double angle = std::atan2(p.z, p.x * std::cos(turn_.at(x)) + p.y * std::sin(turn_.at(x)));
            ofRow.push_back(ofRow.empty() ? angle : near(angle, ofRow.front(), 2 * kPi));
        }
        if (!ofRow.empty()) nods.cells.push_back(y), nods.angles.push_back(medianOf(ofRow));
    }
    if (!fit(std::move(nods), 2 * kPi, nod_)) return false;
    // The middle row about level, or anywhere within a turn of it.
    nod_.first = nod_.first - 2 * kPi * std::round(nod_.at(0.5 * cells.height()) / (2 * kPi));
    return true;
}

glm::dvec3 OpenSky::directionOf(int x, int y) const {
    const double nod = nod_.at(y), turn = turn_.at(x);
    return {std::cos(nod) * std::cos(turn), std::cos(nod) * std::sin(turn), std::sin(nod)};
}

void OpenSky::findOpen(const Scan& scan, const ScanGrid& grid) {
    const int width = grid.pointOfCell.width(), height = grid.pointOfCell.height();
    // Scanners stand upright, but for what their poses say they lean. Where those turn them over, the world's +Z is not
    // what is up (some have +Y), and nobody knows.
    const glm::dvec3 worldsUp = glm::transpose(scan.worldFromScanner.rotation)[2];
    up_ = worldsUp.z > kLeastUpright ? worldsUp : glm::dvec3(0, 0, 1);
    Image<std::uint8_t> mayBe(width, height, 0);
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x < width; ++x)
            mayBe(x, y) = grid.pointOfCell(x, y) < 0 && glm::dot(up_, directionOf(x, y)) > 0;
    });
    const auto both = [](std::uint8_t a, std::uint8_t b) { return std::min(a, b); };
    const auto either = [](std::uint8_t a, std::uint8_t b) { return std::max(a, b); };
    // Where all about a cell may be sky, too: the way to the uppermost leads through no gap narrower than that.
    const Image<std::uint8_t> wide = ofNeighbourhoods(mayBe, closes_, both);
    int top = 0;
    for (int y = 0; y < height; ++y) // about the scanner's own axis: it hardly leans
        if (std::sin(nod_.at(y)) > std::sin(nod_.at(top))) top = y;
    Image<std::uint8_t> reached(width, height, 0);
    std::vector<std::int32_t> toGo;
    const auto reach = [&](int x, int y) {
        if (closes_) x = (x + width) % width;
        if (x < 0 || y < 0 || x >= width || y >= height || !wide(x, y) || reached(x, y)) return;
        reached(x, y) = 1;
        toGo.push_back(y * width + x);
    };
    for (int x = 0; x < width; ++x)
        reach(x, top);
    while (!toGo.empty()) {
        const int cell = toGo.back(), x = cell % width, y = cell / width;
        toGo.pop_back();
        reach(x - 1, y), reach(x + 1, y), reach(x, y - 1), reach(x, y + 1);
    }
    open_ = ofNeighbourhoods(reached, closes_, either); // by what was taken off, all of which may be
    std::int64_t open = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (!open_(x, y)) continue;
            ++open;
            const bool isInside = y > 0 && y + 1 < height && open_(x, y - 1) && open_(x, y + 1);
            if (!isInside || x % kDirectionStride == 0) directions_.emplace_back(directionOf(x, y));
        }
    share_ = static_cast<double>(open) / static_cast<double>(open_.size());
}

int OpenSky::lookUp(double nod, double turn) const {
    const double row = (near(nod, nod_.at(0.5 * open_.height()), 2 * kPi) - nod_.first) / nod_.step;
    const double column = (near(turn, turn_.at(0.5 * open_.width()), 2 * kPi) - turn_.first) / turn_.step;
    int x = static_cast<int>(std::lround(column));
    const int y = static_cast<int>(std::lround(row));
    if (closes_) x = (x % open_.width() + open_.width()) % open_.width();
    // The last cell before the zenith stands for what is above it.
    const bool isAtTop = std::sin(nod) > std::cos(std::abs(nod_.step)) && (y == -1 || y == open_.height());
    if (x < 0 || x >= open_.width() || (!isAtTop && (y < 0 || y >= open_.height()))) return -1;
    return open_(x, std::clamp(y, 0, open_.height() - 1));
}

bool OpenSky::isOpen(const glm::dvec3& directionInScanner) const {
    if (isEmpty() || glm::dot(up_, directionInScanner) < kBelow * glm::length(directionInScanner)) return false;
    const double turn = std::atan2(directionInScanner.y, directionInScanner.x);
    const double nod = std::atan2(directionInScanner.z, std::hypot(directionInScanner.x, directionInScanner.y));
    const int before = lookUp(nod, turn), over = lookUp(kPi - nod, turn + kPi);
    return before != 0 && over != 0 && before + over > -2;
}

} // namespace scene
