#include "app/governed_quality.h"

#include "app/quality_file.h"

#include <algorithm>
#include <string_view>

namespace app {

const render::Quality& GovernedQuality::next(const render::Quality& asked, std::uint64_t frame) {
    nlohmann::json knobs = toJson(asked);
    if (!governor_ || knobs != asked_) {
        asked_ = std::move(knobs);
        ladder_ = ladderOf(asked);
        std::vector<double> costs;
        for (const Rung& rung : ladder_)
            costs.push_back(rung.cost);
        GovernorOptions options;
        options.budgetMilliseconds = 1000 / framesPerSecond_;
        governor_.emplace(std::move(costs), options);
        told_.reset();
    }
    return ladder_[static_cast<std::size_t>(governor_->rungFor(frame))].quality;
}

std::vector<render::Quality> GovernedQuality::ways() const {
    std::vector<render::Quality> ways;
    for (const Rung& rung : ladder_)
        if (ways.empty() || rung.quality.warp != ways.back().warp || rung.quality.isBlended != ways.back().isBlended)
            ways.push_back(rung.quality);
    if (ladder_.size() > ways.size()) ways.push_back(ladder_.back().quality);
    return ways;
}

void GovernedQuality::tell(const render::FrameStats& stats, bool isProcessor) {
    if (!governor_ || stats.gpu.empty() || told_ == stats.gpuFrame) return;
    told_ = stats.gpuFrame;
    // A frame that stands says nothing of what warping costs.
    const auto isWarp = [](const render::StepTime& time) { return std::string_view(time.step) == "warp"; };
    if (std::ranges::none_of(stats.gpu, isWarp)) return;
    const double processor = processorMilliseconds(stats), device = deviceMilliseconds(stats);
    governor_->tell(stats.gpuFrame, isProcessor ? processor + device : std::max(processor, device));
}

std::string GovernedQuality::given() const {
    return governor_ && governor_->rung() > 0 ? ladder_[static_cast<std::size_t>(governor_->rung())].name : "";
}

nlohmann::json GovernedQuality::report() const {
    return governor_ ? toJson(*governor_, ladder_, framesPerSecond_) : nlohmann::json();
}

} // namespace app
