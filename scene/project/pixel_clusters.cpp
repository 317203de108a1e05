#include "scene/project/pixel_clusters.h"

#include "scene/project/colour_mean.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

namespace scene {
namespace {

constexpr std::size_t kChunk = 1 << 14; ///< points; fixed, so that the number of threads changes nothing

struct Candidate {
    double disparity = 0;
    std::uint32_t point = 0;
    bool operator<(const Candidate& other) const {
        return disparity != other.disparity ? disparity < other.disparity : point < other.point;
    }
};

// Points of one pixel that stand on one surface.
struct Cluster {
    std::span<const Candidate> members;
    bool onMesh = false;
};

// Cuts at the widest gap until no cluster spans more than the tolerance: each member is then within it of the
// mean.
void cut(std::span<const Candidate> sorted, double ratio, std::vector<Cluster>& clusters) {
    while (sorted.back().disparity > ratio * sorted.front().disparity) {
        std::size_t widest = 1;
        const auto gap = [&](std::size_t i) { return sorted[i].disparity / sorted[i - 1].disparity; };
        for (std::size_t i = 2; i < sorted.size(); ++i)
            if (gap(i) > gap(widest)) widest = i;
        cut(sorted.first(widest), ratio, clusters);
        sorted = sorted.subspan(widest);
    }
    clusters.push_back({sorted});
}

class Placement {
  public:
    Placement(const Scan& scan, const CubeFrame& frame, int faceIndex, const ScanGrid* grid,
              const Image<MeshPixel>& mesh, const CubeFaceOptions& options, DepthImage& face)
        : scan_(scan), frame_(frame), faceIndex_(faceIndex), grid_(grid), mesh_(mesh), options_(options), face_(face),
          ratio_(1.0 + options.sameSurface) {}

    // Pixel and point in one number that sorts by pixel first.
    std::uint64_t key(std::uint32_t point) const {
        const glm::dvec3 p = frame_.inFace(faceIndex_, scan_.pointsInScanner[point]);
        const glm::dvec2 place = project(face_.camera, p);
        // A point on the very edge of a face rounds to the last pixel.
        const int x = std::clamp(static_cast<int>(std::floor(place.x)), 0, face_.camera.width - 1);
        const int y = std::clamp(static_cast<int>(std::floor(place.y)), 0, face_.camera.height - 1);
        const auto pixel = static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(face_.camera.width) +
                           static_cast<std::uint64_t>(x);
        return pixel << 32 | point;
    }

    void placePixel(std::span<const std::uint64_t> keys, PixelClusters& result) {
        const auto pixel = static_cast<std::size_t>(keys[0] >> 32);
        const auto width = static_cast<std::size_t>(face_.camera.width);
        const int x = static_cast<int>(pixel % width), y = static_cast<int>(pixel / width);
        const MeshPixel shown = mesh_.empty() ? 0 : mesh_(x, y);
        ++result.pixels;

        onMesh_.clear();
        offMesh_.clear();
        for (const std::uint64_t key : keys) {
            const auto point = static_cast<std::uint32_t>(key);
            const double disparity = 1.0 / frame_.inFace(faceIndex_, scan_.pointsInScanner[point]).z;
            (shown != 0 && isOn(shown, disparity, point) ? onMesh_ : offMesh_).push_back({disparity, point});
        }
        if (offMesh_.empty()) {
            result.held += static_cast<std::int64_t>(onMesh_.size());
            return;
        }
        clusters_.clear();
        if (!onMesh_.empty()) clusters_.push_back({onMesh_, true});
        std::sort(offMesh_.begin(), offMesh_.end());
        cut(offMesh_, ratio_, clusters_);
        // Heaviest first; of equals the one that a surface carries, then the nearer.
        std::sort(clusters_.begin(), clusters_.end(), [](const Cluster& a, const Cluster& b) {
            if (a.members.size() != b.members.size()) return a.members.size() > b.members.size();
            if (a.onMesh != b.onMesh) return a.onMesh;
            return a.members[0].disparity > b.members[0].disparity;
        });
        const LayerSample carried{0, x, y, face_.disparity(x, y), face_.colour(x, y), face_.flags(x, y)};
        for (std::size_t rank = 0; rank < clusters_.size(); ++rank) {
            const Cluster& cluster = clusters_[rank];
            const auto weight = static_cast<std::int64_t>(cluster.members.size());
            if (rank > static_cast<std::size_t>(options_.maxLayers)) {
                result.dropped += weight;
                continue;
            }
            result.held += weight;
            LayerSample sample = cluster.onMesh ? carried : meanOf(cluster.members);
            sample.layer = static_cast<int>(rank);
            sample.x = x;
            sample.y = y;
            if (rank > 0) {
                result.further.push_back(sample);
                continue;
            }
            face_.disparity(x, y) = sample.disparity;
            face_.colour(x, y) = sample.colour;
            face_.flags(x, y) = sample.flags;
        }
    }

  private:
    // The triangle that is drawn there is on the surface of its own corners, however steep it is within the
    // pixel.
    bool isOn(MeshPixel shown, double disparity, std::uint32_t point) const {
        const double there = disparityOf(shown);
        if (std::max(there, disparity) <= ratio_ * std::min(there, disparity)) return true;
        for (const std::int32_t corner : cornersOf(*grid_, triangleOf(shown)))
            if (corner == static_cast<std::int32_t>(point)) return true;
        return false;
    }

    LayerSample meanOf(std::span<const Candidate> members) const {
        double disparity = 0;
        ColourMean mean;
        for (const Candidate& member : members) {
            disparity += member.disparity;
            mean.add(scan_, member.point);
        }
        disparity /= static_cast<double>(members.size());
        return {0, 0, 0, static_cast<float>(disparity), mean.colour(), mean.flags()};
    }

    const Scan& scan_;
    const CubeFrame& frame_;
    int faceIndex_;
    const ScanGrid* grid_;
    const Image<MeshPixel>& mesh_;
    const CubeFaceOptions& options_;
    DepthImage& face_;
    double ratio_;
    std::vector<Candidate> onMesh_, offMesh_; // of the pixel at hand; kept for their memory
    std::vector<Cluster> clusters_;
};

} // namespace

PixelClusters placePoints(const Scan& scan, const CubeFrame& frame, int faceIndex,
                          std::span<const std::uint32_t> points, const ScanGrid* grid, const Image<MeshPixel>& mesh,
                          const CubeFaceOptions& options, DepthImage& face) {
    const Placement placement(scan, frame, faceIndex, grid, mesh, options, face);
    std::vector<std::uint64_t> keys(points.size());
    tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t i) { keys[i] = placement.key(points[i]); });
    tbb::parallel_sort(keys.begin(), keys.end());

    // A pixel belongs to the chunk its first point falls into.
    const auto startOf = [&](std::size_t chunk) {
        std::size_t i = std::min(chunk * kChunk, keys.size());
        while (i > 0 && i < keys.size() && keys[i] >> 32 == keys[i - 1] >> 32)
            ++i;
        return i;
    };
    std::vector<PixelClusters> parts((keys.size() + kChunk - 1) / kChunk);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t chunk) {
        Placement own = placement;
        const std::size_t end = startOf(chunk + 1);
        for (std::size_t i = startOf(chunk); i < end;) {
            std::size_t next = i + 1;
            while (next < end && keys[next] >> 32 == keys[i] >> 32)
                ++next;
            own.placePixel(std::span(keys).subspan(i, next - i), parts[chunk]);
            i = next;
        }
    });
    PixelClusters all;
    for (PixelClusters& part : parts) {
        all.held += part.held;
        all.dropped += part.dropped;
        all.pixels += part.pixels;
        all.further.insert(all.further.end(), part.further.begin(), part.further.end());
    }
    return all;
}

} // namespace scene
