#include "tests/app/comparison.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

namespace app {

nlohmann::json readJson(const std::filesystem::path& path) {
    std::ifstream file(path);
    return nlohmann::json::parse(file);
}

double psnr(const cv::Mat3b& a, const cv::Mat3b& b, const cv::Mat1b& where) {
    double sum = 0;
    int count = 0;
    for (int y = 0; y < a.rows; ++y)
        for (int x = 0; x < a.cols; ++x)
            for (int c = 0; c < 3 && where(y, x) != 0; ++c, ++count)
                sum += std::pow(a(y, x)[c] - b(y, x)[c], 2);
    return 10 * std::log10(255.0 * 255.0 * count / std::max(sum, 1e-9));
}

Agreement compareHeldOut(const std::filesystem::path& scene, const std::filesystem::path& frames,
                         const std::function<std::filesystem::path(const std::string&)>& truthOf) {
    constexpr int kSeen = 1, kFilled = 2;
    Agreement agreement;
    const nlohmann::json manifest = readJson(scene / "scene.json");
    for (const auto& camera : manifest.at("held_out")) {
        const std::string name = camera.at("name");
        const cv::Mat3b drawn = cv::imread((frames / (name + ".png")).string(), cv::IMREAD_COLOR);
        const cv::Mat3b truth = cv::imread(truthOf(name).string(), cv::IMREAD_COLOR);
        const cv::Mat1b pixelClass = cv::imread((frames / (name + "-class.png")).string(), cv::IMREAD_UNCHANGED);
        if (drawn.empty() || drawn.size() != truth.size() || drawn.size() != pixelClass.size()) {
            ADD_FAILURE() << name << ": drawn " << drawn.size() << ", truth " << truth.size() << ", class "
                          << pixelClass.size();
            continue;
        }
        const cv::Mat1b seen(pixelClass == kSeen);
        const cv::Mat1b covered((pixelClass == kSeen) | (pixelClass == kFilled));
        agreement.meanPsnr += psnr(drawn, truth, seen);
        agreement.seenShare += cv::countNonZero(seen) / static_cast<double>(seen.total());
        agreement.coveredPsnr += psnr(drawn, truth, covered);
        agreement.coveredShare += cv::countNonZero(covered) / static_cast<double>(covered.total());
        ++agreement.pictures;
    }
    agreement.meanPsnr /= std::max(agreement.pictures, 1);
    agreement.seenShare /= std::max(agreement.pictures, 1);
    agreement.coveredPsnr /= std::max(agreement.pictures, 1);
    agreement.coveredShare /= std::max(agreement.pictures, 1);
    return agreement;
}

} // namespace app
