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
    void add(const PartnerWord& word) { agrees += word.agrees, sawThrough += word.sawThrough; }
    void subtract(const PartnerWord& word) { agrees -= word.agrees, sawThrough -= word.sawThrough; }
};

class Search {
  public:
    Search(std::span<const SkinFigures> images, const ContradictionOptions& options)
        : options_(options), images_(images), pairs_(images.size()), said_(images.size()),
          isNamed_(images.size(), false) {
        for (std::uint32_t i = 0; i < images.size(); ++i)
            for (const PartnerWord& word : images[i].words) {
                pairs_[i].push_back(word);
                pairs_[word.image].push_back({i, word.agrees, word.sawThrough});
            }
        for (std::size_t i = 0; i < images.size(); ++i)
            for (const PartnerWord& word : pairs_[i])
                said_[i].add(word);
    }

    std::vector<Contradiction> find() {
        std::vector<bool> isPassedOver(images_.size(), false);
        while (const std::optional<std::size_t> worst = worstBut(isPassedOver)) {
            const double share = said_[*worst].share();
            name(*worst);
            if (share >= options_.timesMedian * shareInTheMiddle() && haveOthers(*worst)) {
                named_.push_back(*worst);
                isPassedOver.assign(images_.size(), false); // with one less that speaks against all
            } else {
                takeBack(*worst);
                isPassedOver[*worst] = true;
            }
        }
        takeBackWhoIsRight();
        std::vector<Contradiction> found;
        for (const std::size_t image : named_)
            found.push_back({image, saidByRest(image).share()});
        std::stable_sort(found.begin(), found.end(),
                         [](const Contradiction& a, const Contradiction& b) { return a.share > b.share; });
        return found;
    }

  private:
    bool isEnough(const Said& said, std::size_t image) const {
        return said.words() > 0 &&
               static_cast<double>(said.words()) >= options_.spokenOf * static_cast<double>(images_[image].samples);
    }

    std::optional<std::size_t> worstBut(const std::vector<bool>& isPassedOver) const {
        std::optional<std::size_t> worst;
        for (std::size_t i = 0; i < images_.size(); ++i) {
            if (isNamed_[i] || isPassedOver[i] || !isEnough(said_[i], i) || said_[i].share() < options_.share) continue;
            if (!worst || said_[i].share() > said_[*worst].share()) worst = i;
        }
        return worst;
    }

    /// What named ones say, and what is said of them, counts no more for the others.
    void name(std::size_t image) {
        isNamed_[image] = true;
        for (const PartnerWord& word : pairs_[image])
            if (!isNamed_[word.image]) said_[word.image].subtract(word);
    }
    void takeBack(std::size_t image) {
        isNamed_[image] = false;
        said_[image] = saidByRest(image);
        for (const PartnerWord& word : pairs_[image])
            if (!isNamed_[word.image]) said_[word.image].add(word);
    }

    /// Of an image and all that are not named.
    Said saidByRest(std::size_t image) const {
        Said said;
        for (const PartnerWord& word : pairs_[image])
            if (!isNamed_[word.image]) said.add(word);
        return said;
    }

    double shareInTheMiddle() const {
        std::vector<double> shares;
        for (std::size_t i = 0; i < images_.size(); ++i)
            if (!isNamed_[i] && said_[i].words() > 0) shares.push_back(said_[i].share());
        return medianOf(shares);
    }

    /// Whether somebody whom the image contradicts has others, too, that speak for him.
    bool haveOthers(std::size_t image) const {
        return std::any_of(pairs_[image].begin(), pairs_[image].end(), [&](const PartnerWord& word) {
            const Said pair{word.agrees, word.sawThrough};
            return !isNamed_[word.image] && pair.words() > 0 && pair.share() >= options_.share &&
                   static_cast<double>(said_[word.image].agrees) >=
                       options_.spokenOf * static_cast<double>(images_[word.image].samples);
        });
    }

    /// Of those named early some were contradicted by others alone that were named later.
    void takeBackWhoIsRight() {
        const auto isRight = [&](std::size_t image) {
            const Said said = saidByRest(image);
            return !isEnough(said, image) || said.share() < options_.share ||
                   said.share() < options_.timesMedian * shareInTheMiddle();
        };
        for (auto at = named_.begin(); at != named_.end();) {
            if (!isRight(*at)) {
                ++at;
                continue;
            }
            takeBack(*at);
            named_.erase(at);
            at = named_.begin(); // the others are asked again by one more
        }
    }

    const ContradictionOptions& options_;
    std::span<const SkinFigures> images_;
    std::vector<std::vector<PartnerWord>> pairs_; ///< of each image, what either says of the other's samples
    std::vector<Said> said_;                      ///< of each image, with all that are not named
    std::vector<bool> isNamed_;
    std::vector<std::size_t> named_;
};

} // namespace

std::vector<Contradiction> findContradictions(std::span<const SkinFigures> images,
                                              const ContradictionOptions& options) {
    return Search(images, options).find();
}

} // namespace scene
