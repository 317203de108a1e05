#include "scene/refine/contradiction.h"

#include "scene/median.h"

#include <algorithm>
#include <cstdint>
#include <optional>

namespace scene {

namespace {

/// What images say of each other's samples.
struct Said {
    std::int64_t agrees = 0, sawThrough = 0;

    std::int64_t words() const { return agrees + sawThrough; }
    double share() const { return words() > 0 ? static_cast<double>(sawThrough) / static_cast<double>(words()) : 0; }
};

/// Of each image, summed over those that it was compared with, without those named already.
std::vector<Said> saidOf(std::span<const SkinFigures> images, const std::vector<bool>& isNamed) {
    std::vector<Said> said(images.size());
    for (std::size_t i = 0; i < images.size(); ++i)
        for (const PartnerWord& word : images[i].words) {
            if (isNamed[i] || isNamed[word.image]) continue;
            for (const std::size_t of : {i, std::size_t{word.image}})
                said[of].agrees += word.agrees, said[of].sawThrough += word.sawThrough;
        }
    return said;
}

/// Whether somebody whom the image contradicts has others, too, that speak for him.
bool haveOthers(std::span<const SkinFigures> images, std::size_t image, const std::vector<Said>& saidByRest) {
    for (std::size_t i = 0; i < images.size(); ++i)
        for (const PartnerWord& word : images[i].words) {
            if (i != image && word.image != image) continue;
            if (word.sawThrough > 0 && saidByRest[i == image ? word.image : i].agrees > 0) return true;
        }
    return false;
}

double shareInTheMiddle(const std::vector<Said>& said) {
    std::vector<double> shares;
    for (const Said& s : said)
        if (s.words() > 0) shares.push_back(s.share());
    return medianOf(shares);
}

} // namespace

std::vector<Contradiction> findContradictions(std::span<const SkinFigures> images,
                                              const ContradictionOptions& options) {
    std::vector<Contradiction> found;
    std::vector<bool> isNamed(images.size(), false);
    std::vector<Said> said = saidOf(images, isNamed);
    const auto isEnough = [&](std::size_t i) {
        return static_cast<double>(said[i].words()) >= options.spokenOf * static_cast<double>(images[i].samples);
    };
    for (;;) {
        std::optional<Contradiction> worst;
        for (std::size_t i = 0; i < images.size(); ++i)
            if (said[i].words() > 0 && isEnough(i) && said[i].share() > (worst ? worst->share : 0))
                worst = {i, said[i].share()};
        if (!worst || worst->share < options.share) return found;
        isNamed[worst->image] = true;
        said = saidOf(images, isNamed);
        if (worst->share < options.timesMedian * shareInTheMiddle(said) || !haveOthers(images, worst->image, said))
            return found;
        found.push_back(*worst);
    }
}

} // namespace scene
