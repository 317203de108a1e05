#include "scene/capture/write_scans.h"

#include "scene/errors.h"
#include "scene/image.h"
#include "scene/unfinished_file.h"

#include <cassert>
#include <cstdio>
#include <fstream>

namespace scene {

namespace {

/// As import/ptx.h has it: the scanner's place and axes, then the same as a matrix for row vectors.
void writeHeader(std::ofstream& file, const Scan& scan) {
    const Pose& pose = scan.worldFromScanner;
    const auto tell = [&](const glm::dvec3& v, const char* end) {
        char line[120];
        std::snprintf(line, sizeof line, "%.12g %.12g %.12g%s\n", v.x, v.y, v.z, end);
        file << line;
    };
    file << scan.columns << '\n' << scan.rows << '\n';
    tell(pose.translation, "");
    for (int axis = 0; axis < 3; ++axis)
        tell(pose.rotation[axis], "");
    for (int axis = 0; axis < 3; ++axis)
        tell(pose.rotation[axis], " 0");
    tell(pose.translation, " 1");
}

} // namespace

void writePtx(const std::filesystem::path& path, std::size_t count,
              const std::function<ScanWithIntensity(std::size_t)>& scanAt) {
    const UnfinishedFile unfinished(path);
    std::ofstream file(unfinished.path(), std::ios::binary);
    for (std::size_t k = 0; k < count && file; ++k) {
        const ScanWithIntensity written = scanAt(k);
        const Scan& scan = written.scan;
        assert(scan.rows > 0 && scan.columns > 0 && written.intensities.size() == scan.pointsInScanner.size());
        Image<std::int64_t> pointOfCell(scan.columns, scan.rows, -1);
        for (std::size_t i = 0; i < scan.row.size(); ++i)
            pointOfCell(scan.column[i], scan.row[i]) = static_cast<std::int64_t>(i);
        writeHeader(file, scan);
        char line[120];
        for (int column = 0; column < scan.columns; ++column)
            for (int row = 0; row < scan.rows; ++row) {
                const std::int64_t point = pointOfCell(column, row);
                if (point < 0) {
                    file << (scan.hasColour ? "0 0 0 0.5 0 0 0\n" : "0 0 0 0.5\n");
                    continue;
                }
                const auto i = static_cast<std::size_t>(point);
                const glm::dvec3 p(scan.pointsInScanner[i]);
                const Rgb8& c = scan.colours[i];
                const double intensity = static_cast<double>(written.intensities[i]);
                if (scan.hasColour)
                    std::snprintf(line, sizeof line, "%.4f %.4f %.4f %.6f %d %d %d\n", p.x, p.y, p.z, intensity, c.r,
                                  c.g, c.b);
                else
                    std::snprintf(line, sizeof line, "%.4f %.4f %.4f %.6f\n", p.x, p.y, p.z, intensity);
                file << line;
            }
    }
    file.close();
    if (!file) throw Failure("cannot be written", path, kWriteRemedy);
    unfinished.finish();
}

} // namespace scene
