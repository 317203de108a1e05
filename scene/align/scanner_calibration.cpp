#include "scene/align/scanner_calibration.h"

#include "scene/align/scan_planes.h"
#include "scene/median.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include <Eigen/Dense>
#include <ceres/ceres.h>
#include <glm/geometric.hpp>

namespace scene {

namespace {

/// How far the second face's samples of a plane may lie from where the first face has it: what wrong constants do.
constexpr double kGateMetres = 0.03, kGateShare = 0.02;
constexpr double kGateDeviations = 4; ///< once constants are about right
constexpr double kRobustDeviations = 2.0;
constexpr int kLeastSamples = 200;                   ///< of a plane and face: fewer say nothing that noise does not
constexpr double kLeastArea = 0.3;                   ///< square metres; small things are seldom as plane as they look
constexpr double kUsualNoise = 0.006, kMostMore = 6; ///< metres; times the samples of usual scans
constexpr std::size_t kLeastPlanes = 6;
/// A degree each: in finer cells noise decides how far out a plane is found, and not evenly to both its sides.
constexpr int kPanoramaRows = 180;
/// What samples do not tell of the mirror's distance. Range along glancing surfaces is no straight line within a
/// position of the encoder: 2 mm. And noise has a say in what counts as part of a plane: found 4 to 6 mm too great
/// where samples leave planes by 15 mm (docs/building.md).
constexpr double kRangeSystematicMetres = 0.002, kSystematicOfNoise = 0.3;
/// Metres; none at all would be believed too much. And of how many patches both faces say how uneven a plane is.
constexpr double kLeastUneven = 0.0001, kUsuallyUneven = 0.001;
constexpr int kLeastShared = 10;
constexpr int kConstants = 4;

using Numbers = std::array<double, kConstants>;

Numbers numbersOf(const ScannerConstants<double>& c) {
    return {c.panStepsPerHalfTurn, c.mirrorRadians, c.horizonPosition, c.mirrorMetres};
}

ScannerConstants<double> constantsOf(const Numbers& n) {
    return {n[0], n[1], n[2], n[3]};
}

/// A record that is taken to lie on a patch of a plane.
struct Taken {
    ScannerRecord record;
    ScannerFace face;
    std::size_t patch = 0;
};

/// A plane that both faces saw, as the vector whose product with each of its points is 1.
struct FacedPlane {
    std::array<double, 3> reciprocal{};
    double noiseMetres = 0;
    double unevenMetres = 0; ///< standard deviation of its patches from it
};

/// What a cell of the panorama shows of a plane. Frames and shelves stand before walls by less than noise tells: a
/// patch may stand off its plane, for both faces alike, by as much as patches of that plane usually do.
struct Patch {
    std::size_t plane = 0;
    double offMetres = 0;
};

/// Planes and what was seen of them, of all scans.
struct Sightings {
    std::vector<FacedPlane> planes;
    std::vector<Patch> patches; ///< of a plane one after the other
    std::vector<Taken> taken;
};

/// The distance of a record's place from its patch, in deviations.
struct DistanceOffPatch {
    ScannerRecord record;
    double weight;

    template <class T>
    bool operator()(const T* c, const T* w, const T* off, T* residual) const {
        const ScannerConstants<T> constants{c[0], c[1], c[2], c[3]};
        const std::array<T, 3> p = scannedPoint<T>(constants, T(record.encoder), T(record.pan), T(record.rangeMetres));
        using std::sqrt;
        const T length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
        residual[0] = ((w[0] * p[0] + w[1] * p[1] + w[2] * p[2] - T(1)) / length - off[0]) * weight;
        return true;
    }
};

/// All that is known of a patch: its records' distances, robustly, and last how far it stands off its plane, all in
/// deviations. Of the constants, the plane's reciprocal and the patch's own offset. One block for hundreds of records
/// costs the solver far less than a block for each. Robust they are made here, a loss being one for a block: a
/// distance r is said to be the root of what Cauchy's loss makes of it, so that its square is that loss. What is
/// sought is the same as with Cauchy's loss of each; steps towards it weigh outliers less.
class PatchResiduals : public ceres::CostFunction {
  public:
    PatchResiduals(std::vector<DistanceOffPatch> distances, double usualWeight)
        : distances_(std::move(distances)), usualWeight_(usualWeight) {
        *mutable_parameter_block_sizes() = {kConstants, 3, 1};
        set_num_residuals(static_cast<int>(distances_.size()) + 1);
    }

    bool Evaluate(const double* const* at, double* residuals, double** jacobians) const override {
        if (jacobians == nullptr) {
            for (std::size_t i = 0; i < distances_.size(); ++i) {
                double r = 0;
                distances_[i](at[0], at[1], at[2], &r);
                residuals[i] = robust(r).value;
            }
        } else {
            std::array<Jet, kConstants> constants;
            std::array<Jet, 3> reciprocal;
            for (int k = 0; k < kConstants; ++k)
                constants[static_cast<std::size_t>(k)] = Jet(at[0][k], k);
            for (int k = 0; k < 3; ++k)
                reciprocal[static_cast<std::size_t>(k)] = Jet(at[1][k], kConstants + k);
            const Jet off(at[2][0], kConstants + 3);
            for (std::size_t i = 0; i < distances_.size(); ++i) {
                Jet r;
                distances_[i](constants.data(), reciprocal.data(), &off, &r);
                const Robust made = robust(r.a);
                residuals[i] = made.value;
                setRow(i, made.slope * r.v, jacobians);
            }
            Slopes usual = Slopes::Zero();
            usual[kConstants + 3] = usualWeight_;
            setRow(distances_.size(), usual, jacobians);
        }
        residuals[distances_.size()] = at[2][0] * usualWeight_;
        return true;
    }

  private:
    using Jet = ceres::Jet<double, kConstants + 4>;
    using Slopes = Eigen::Matrix<double, kConstants + 4, 1>;
    struct Robust {
        double value, slope;
    };
    static Robust robust(double r) {
        constexpr double kSquare = kRobustDeviations * kRobustDeviations;
        const double s = r * r;
        if (!(s > 1e-12 * kSquare)) return {r, 1}; // the root's own slope would be 0 / 0
        const double share = std::sqrt(kSquare * std::log1p(s / kSquare) / s);
        return {r * share, 1 / ((1 + s / kSquare) * share)};
    }
    /// jacobians: of each block by rows, null where a block is held.
    static void setRow(std::size_t row, const Slopes& slopes, double** jacobians) {
        int from = 0;
        for (const int block : {0, 1, 2}) {
            const int size = block == 0 ? kConstants : block == 1 ? 3 : 1;
            if (jacobians[block] != nullptr)
                std::copy_n(slopes.data() + from, size, jacobians[block] + row * static_cast<std::size_t>(size));
            from += size;
        }
    }

    std::vector<DistanceOffPatch> distances_;
    double usualWeight_;
};

double distanceOf(const ScannerConstants<double>& constants, const FacedPlane& plane, const ScannerRecord& record) {
    const Numbers c = numbersOf(constants);
    const double off = 0;
    double distance = 0;
    DistanceOffPatch{record, 1}(c.data(), plane.reciprocal.data(), &off, &distance);
    return distance;
}

double medianNoiseOf(const std::vector<FacedPlane>& planes) {
    std::vector<double> noises;
    for (const FacedPlane& plane : planes)
        noises.push_back(plane.noiseMetres);
    return medianOf(noises);
}

/// The scan with the samples of one face alone.
Scan ofFace(const Scan& scan, const ScanRecords& records, ScannerFace face) {
    Scan half;
    half.rows = scan.rows, half.columns = scan.columns;
    for (std::size_t i = 0; i < scan.pointsInScanner.size(); ++i) {
        if (records.faces[i] != face) continue;
        half.pointsInScanner.push_back(scan.pointsInScanner[i]);
        half.row.push_back(scan.row[i]), half.column.push_back(scan.column[i]);
    }
    half.colours.resize(half.pointsInScanner.size());
    return half;
}

/// Which cells lie on a plane together with all about them that saw anything. At a plane's rim luck decides which cells
/// are taken for part of it, and beams are averaged with what stands beside it: what is taken there is not even. Where
/// nothing came back there is nothing to average with. The rows at the poles have nobody beyond them and never count.
Image<std::uint8_t> withinPlanes(const Panorama& panorama) {
    const int width = panorama.width(), height = panorama.height();
    Image<std::uint8_t> within(width, height, std::uint8_t{0});
    for (int y = 1; y + 1 < height; ++y)
        for (int x = 0; x < width; ++x) {
            const int plane = panorama.cells(x, y).plane;
            bool isWithin = plane >= 0;
            for (int j = y - 1; j <= y + 1 && isWithin; ++j)
                for (const int i : {(x + width - 1) % width, x, (x + 1) % width}) {
                    const PanoramaCell& beside = panorama.cells(i, j);
                    isWithin &= beside.plane == plane || beside.samples == 0;
                }
            within(x, y) = isWithin;
        }
    return within;
}

/// Adds what a scan, read with `constants`, shows of planes that both faces saw. most: samples to add.
void addSightings(const Scan& scan, const ScanRecords& records, bool isFirstPass, std::size_t most,
                  Sightings& sightings) {
    // Wrong constants part the faces' planes: they are then looked for in one face, and the other's samples near them.
    const Scan front = isFirstPass ? ofFace(scan, records, ScannerFace::front) : Scan();
    const Scan& whole = isFirstPass ? front : scan;
    Panorama panorama = panoramaOf(whole, kPanoramaRows);
    const std::vector<ScanPlane> planes = planesOf(whole, panorama);
    const Image<std::uint8_t> within = withinPlanes(panorama);

    struct Seen {
        std::size_t sample, cell;
    };
    std::vector<std::array<std::vector<Seen>, 2>> seen(planes.size());
    for (std::size_t i = 0; i < records.records.size(); ++i) {
        if (!(records.records[i].rangeMetres > 0)) continue;
        const glm::dvec3 p(scan.pointsInScanner[i]);
        const auto place = panorama.placeOf(p);
        if (!place || !within((*place)[0], (*place)[1])) continue;
        const auto k = static_cast<std::size_t>(panorama.cells((*place)[0], (*place)[1]).plane);
        const ScanPlane& plane = planes[k];
        const double gate = isFirstPass ? kGateMetres + kGateShare * glm::length(p)
                                        : std::max(kGateDeviations * plane.noiseMetres, 0.002);
        if (std::abs(glm::dot(plane.normal, p) - plane.offset) < gate)
            seen[k][records.faces[i] == ScannerFace::back].push_back(
                {i, static_cast<std::size_t>((*place)[1] * panorama.width() + (*place)[0])});
    }
    std::vector<std::size_t> both;
    for (std::size_t k = 0; k < planes.size(); ++k)
        if (planes[k].areaSquareMetres >= kLeastArea && seen[k][0].size() >= kLeastSamples &&
            seen[k][1].size() >= kLeastSamples && planes[k].offset < -0.05)
            both.push_back(k);
    if (both.empty()) return;
    // Noise falls as the root of what is taken: of a noisier scan, more.
    std::vector<double> noises;
    for (const std::size_t k : both)
        noises.push_back(planes[k].noiseMetres);
    const double more = std::clamp(std::pow(medianOf(noises) / kUsualNoise, 2), 1.0, kMostMore);
    const std::size_t mostOfFace = std::max<std::size_t>(
        static_cast<std::size_t>(more * static_cast<double>(most)) / (2 * both.size()), kLeastSamples);
    constexpr std::size_t kNone = ~std::size_t{0};
    std::vector<std::size_t> patchOf(
        static_cast<std::size_t>(panorama.width()) * static_cast<std::size_t>(panorama.height()), kNone);
    for (const std::size_t k : both) {
        const glm::dvec3 w = planes[k].normal / planes[k].offset;
        for (const std::vector<Seen>& samples : seen[k]) {
            const std::size_t count = std::min(samples.size(), mostOfFace);
            for (std::size_t j = 0; j < count; ++j) {
                const Seen& one = samples[j * samples.size() / count];
                if (patchOf[one.cell] == kNone) {
                    patchOf[one.cell] = sightings.patches.size();
                    sightings.patches.push_back({sightings.planes.size(), 0});
                }
                sightings.taken.push_back({records.records[one.sample], records.faces[one.sample], patchOf[one.cell]});
            }
        }
        sightings.planes.push_back({{w.x, w.y, w.z}, std::max(planes[k].noiseMetres, 0.0005)});
    }
}

/// How uneven planes are: in what both faces saw of their patches, noise is each's own.
void measureUnevenness(const ScannerConstants<double>& constants, Sightings& sightings) {
    struct Sum {
        double distance = 0;
        int samples = 0;
    };
    std::vector<std::array<Sum, 2>> sums(sightings.patches.size());
    for (const Taken& taken : sightings.taken) {
        Sum& sum = sums[taken.patch][taken.face == ScannerFace::back];
        sum.distance += distanceOf(constants, sightings.planes[sightings.patches[taken.patch].plane], taken.record);
        ++sum.samples;
    }
    struct Moments {
        double weight = 0, front = 0, back = 0, product = 0;
        int patches = 0; ///< that both faces saw
    };
    std::vector<Moments> moments(sightings.planes.size());
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const auto [front, back] = sums[i];
        if (front.samples == 0 || back.samples == 0) continue;
        const double weight = 1.0 * front.samples * back.samples / (front.samples + back.samples);
        const double f = front.distance / front.samples, b = back.distance / back.samples;
        Moments& m = moments[sightings.patches[i].plane];
        ++m.patches, m.weight += weight, m.front += weight * f, m.back += weight * b, m.product += weight * f * b;
    }
    std::vector<double> known;
    for (std::size_t k = 0; k < moments.size(); ++k) {
        const Moments& m = moments[k];
        if (m.patches < kLeastShared) continue;
        const double covariance = m.product / m.weight - m.front * m.back / (m.weight * m.weight);
        sightings.planes[k].unevenMetres = std::sqrt(std::max(covariance, kLeastUneven * kLeastUneven));
        known.push_back(sightings.planes[k].unevenMetres);
    }
    // Of what the faces hardly saw in the same places nothing is known: it is then like the others.
    const double usual = known.empty() ? kUsuallyUneven : medianOf(known);
    for (std::size_t k = 0; k < moments.size(); ++k)
        if (moments[k].patches < kLeastShared) sightings.planes[k].unevenMetres = usual;
}

/// Of the middle 90 % by size.
double rmsOf(const ScannerConstants<double>& constants, const Sightings& sightings) {
    std::vector<double> squares;
    for (const Taken& taken : sightings.taken) {
        const double distance =
            distanceOf(constants, sightings.planes[sightings.patches[taken.patch].plane], taken.record);
        squares.push_back(distance * distance);
    }
    if (squares.empty()) return 0;
    const std::size_t kept = std::max<std::size_t>(squares.size() * 9 / 10, 1);
    std::nth_element(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(kept - 1), squares.end());
    double sum = 0;
    for (std::size_t i = 0; i < kept; ++i)
        sum += squares[i];
    return std::sqrt(sum / static_cast<double>(kept));
}

void adjust(Sightings& sightings, Numbers& constants) {
    ceres::Problem problem;
    auto* order = new ceres::ParameterBlockOrdering; // the solver's
    problem.AddParameterBlock(constants.data(), kConstants);
    order->AddElementToGroup(constants.data(), 1);
    for (FacedPlane& plane : sightings.planes) {
        problem.AddParameterBlock(plane.reciprocal.data(), 3);
        order->AddElementToGroup(plane.reciprocal.data(), 1);
    }
    std::vector<std::vector<DistanceOffPatch>> distances(sightings.patches.size());
    for (const Taken& taken : sightings.taken)
        distances[taken.patch].push_back(
            {taken.record, 1 / sightings.planes[sightings.patches[taken.patch].plane].noiseMetres});
    for (std::size_t i = 0; i < distances.size(); ++i) { // patches know nothing of each other
        Patch& patch = sightings.patches[i];
        FacedPlane& plane = sightings.planes[patch.plane];
        problem.AddParameterBlock(&patch.offMetres, 1);
        order->AddElementToGroup(&patch.offMetres, 0);
        problem.AddResidualBlock(new PatchResiduals(std::move(distances[i]), 1 / plane.unevenMetres), nullptr,
                                 constants.data(), plane.reciprocal.data(), &patch.offMetres);
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.linear_solver_ordering.reset(order);
    options.max_num_iterations = 30;
    options.function_tolerance = 1e-9;
    options.num_threads = 1; // the same bytes everywhere
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
}

/// Standard deviations of the constants. Samples of a plane share its faults (it is not quite one), so each plane
/// counts as one observation: the sandwich of White, by clusters.
Numbers deviationsOf(const Sightings& sightings, const Numbers& constants) {
    constexpr int kNumbers = kConstants + 3;
    using Row = Eigen::Matrix<double, kNumbers, 1>;
    using Square = Eigen::Matrix<double, kNumbers, kNumbers>;
    std::vector<Square> hessians(sightings.planes.size(), Square::Zero());
    std::vector<Row> gradients(sightings.planes.size(), Row::Zero());
    struct Sums {
        Row shared = Row::Zero();
        double own = 0, gradient = 0;
    };
    std::vector<Sums> patches(sightings.patches.size());
    using Jet = ceres::Jet<double, kNumbers + 1>;
    std::array<Jet, kConstants> c;
    for (int i = 0; i < kConstants; ++i)
        c[static_cast<std::size_t>(i)] = Jet(constants[static_cast<std::size_t>(i)], i);
    for (const Taken& taken : sightings.taken) {
        const Patch& patch = sightings.patches[taken.patch];
        const FacedPlane& plane = sightings.planes[patch.plane];
        std::array<Jet, 3> w;
        for (int i = 0; i < 3; ++i)
            w[static_cast<std::size_t>(i)] = Jet(plane.reciprocal[static_cast<std::size_t>(i)], kConstants + i);
        const Jet off(patch.offMetres, kNumbers);
        Jet residual;
        DistanceOffPatch{taken.record, 1 / plane.noiseMetres}(c.data(), w.data(), &off, &residual);
        const double loss = 1 / (1 + residual.a * residual.a / (kRobustDeviations * kRobustDeviations));
        const Row slope = residual.v.head<kNumbers>();
        const double ownSlope = residual.v[kNumbers];
        hessians[patch.plane] += loss * slope * slope.transpose();
        gradients[patch.plane] += loss * residual.a * slope;
        patches[taken.patch].shared += loss * ownSlope * slope;
        patches[taken.patch].own += loss * ownSlope * ownSlope;
        patches[taken.patch].gradient += loss * residual.a * ownSlope;
    }
    // Patches' own numbers are eliminated first,
    for (std::size_t i = 0; i < patches.size(); ++i) {
        const Patch& patch = sightings.patches[i];
        const double usual = 1 / std::pow(sightings.planes[patch.plane].unevenMetres, 2);
        const Row through = patches[i].shared / (patches[i].own + usual);
        hessians[patch.plane] -= through * patches[i].shared.transpose();
        gradients[patch.plane] -= through * (patches[i].gradient + usual * patch.offMetres);
    }
    // then each plane's own three: what is left speaks of the constants.
    Eigen::Matrix4d information = Eigen::Matrix4d::Zero(), scatter = Eigen::Matrix4d::Zero();
    for (std::size_t k = 0; k < hessians.size(); ++k) {
        const Eigen::Matrix3d own = hessians[k].bottomRightCorner<3, 3>();
        const Eigen::Matrix<double, kConstants, 3> shared = hessians[k].topRightCorner<kConstants, 3>();
        const Eigen::Matrix<double, kConstants, 3> through = own.ldlt().solve(shared.transpose()).transpose();
        information += hessians[k].topLeftCorner<kConstants, kConstants>() - through * shared.transpose();
        const Eigen::Vector4d gradient = gradients[k].head<kConstants>() - through * gradients[k].tail<3>();
        scatter += gradient * gradient.transpose();
    }
    // Constants are of very different size: scaled before they are divided by.
    const Eigen::Vector4d scale = information.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
    const Eigen::Matrix4d scaled = scale.asDiagonal() * information * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(scaled);
    const Eigen::Matrix4d inverse = solver.eigenvectors() *
                                    solver.eigenvalues().cwiseMax(1e-12).cwiseInverse().asDiagonal() *
                                    solver.eigenvectors().transpose();
    const Eigen::Matrix4d half = scale.asDiagonal() * inverse * scale.asDiagonal();
    const auto planes = static_cast<double>(hessians.size());
    const double freedom = planes > kConstants ? planes / (planes - kConstants) : planes;
    const Eigen::Matrix4d covariance = half * scatter * half * freedom;
    Numbers deviations{};
    for (int i = 0; i < kConstants; ++i) // at the optimum few planes may agree by chance: samples' noise is the least
        deviations[static_cast<std::size_t>(i)] = std::sqrt(std::max({covariance(i, i), half(i, i), 0.0}));
    return deviations;
}

std::string whatIsLacking(const ScannerConstants<double>& d) {
    // Written so that what is no number is not found either.
    if (!(d.panStepsPerHalfTurn <= kMostStepsDeviation)) return "the steps of the pan unit cannot be told";
    if (!(d.mirrorRadians <= kMostMirrorDeviation)) return "the mirror's angle cannot be told";
    if (!(d.horizonPosition <= kMostHorizonDeviation)) return "the encoder's horizon cannot be told";
    if (!(d.mirrorMetres <= kMostMetresDeviation))
        return "the distance to the mirror cannot be told from ranges as noisy as these";
    return {};
}

} // namespace

ScannerCalibration calibrateScanner(std::size_t scans, const std::function<Scan(std::size_t)>& scanAt,
                                    const ScannerConstants<double>& believed,
                                    const ScannerCalibrationOptions& options) {
    ScannerCalibration result;
    assert(options.passes > 0);
    Numbers constants = numbersOf(believed);
    Sightings sightings;
    for (int pass = 0; pass < options.passes; ++pass) {
        sightings = {};
        for (std::size_t i = 0; i < scans; ++i) {
            Scan scan = scanAt(i);
            const ScanRecords records = recordsOf(scan, believed, scan.name);
            if (pass > 0) readAnew(scan, records, constantsOf(constants));
            addSightings(scan, records, pass == 0, static_cast<std::size_t>(options.mostSamples) / scans, sightings);
        }
        if (sightings.planes.size() < kLeastPlanes) {
            result.constants = believed;
            result.why = "fewer than six planes were seen by both halves of the mirror's turn";
            return result;
        }
        if (pass == 0) result.rmsBeforeMetres = rmsOf(believed, sightings);
        measureUnevenness(constantsOf(constants), sightings);
        adjust(sightings, constants);
    }
    result.constants = constantsOf(constants);
    result.deviations = constantsOf(deviationsOf(sightings, constants));
    result.deviations.mirrorMetres = std::hypot(result.deviations.mirrorMetres, kRangeSystematicMetres,
                                                kSystematicOfNoise * medianNoiseOf(sightings.planes));
    result.planes = static_cast<int>(sightings.planes.size());
    result.samples = std::ssize(sightings.taken);
    result.rmsAfterMetres = rmsOf(result.constants, sightings);
    result.why = whatIsLacking(result.deviations);
    if (!(result.rmsAfterMetres <= result.rmsBeforeMetres)) result.why = "what was seen fits no constants better";
    if (!result.why.empty()) {
        result.why += ": walls about the scanner must be seen by both halves of the mirror's turn";
        result.constants = believed;
    }
    return result;
}

} // namespace scene
