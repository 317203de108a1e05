#include "tests/bench/bare_scatter.h"

#include "spirv/bare_scatter.comp.h"

#include <array>
#include <cstring>
#include <vector>

namespace render {

namespace {

constexpr std::uint32_t kWorkgroupSize = 256;

struct Record {
    float x, y, z;
    std::uint32_t colour;
};

struct Constants {
    float imageFromRecords[16];
    std::uint32_t count, width, height;
};

std::vector<Record> recordsOf(std::span<const scene::TileBlock> blocks) {
    std::vector<Record> records;
    for (const scene::TileBlock& block : blocks)
        for (const scene::Tile& tile : block.tiles)
            for (const scene::TileVertex& vertex : block.vertices.subspan(tile.firstVertex, tile.pointCount)) {
                const double x = tile.x0 + static_cast<int>(scene::placeOf(tile, vertex).x) + 0.5;
                const double y = tile.y0 + static_cast<int>(scene::placeOf(tile, vertex).y) + 0.5;
                const glm::dvec3 pInCamera =
                    scene::rayThrough(block.camera, x, y) / static_cast<double>(scene::disparityOf(tile, vertex));
                const glm::vec3 p(block.worldFromCamera * pInCamera);
                records.push_back({p.x, p.y, p.z, vertex.colour << 8 | 1});
            }
    return records;
}

} // namespace

BareScatter::BareScatter(const Device& device, std::span<const scene::TileBlock> blocks, int width, int height)
    : device_(device), width_(width), height_(height), timer_(device), streams_(device, 1) {
    const std::vector<Record> records = recordsOf(blocks);
    samples_ = records.size();
    records_ = upload(device, std::as_bytes(std::span(records)), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    zBuffer_ = Buffer(device, static_cast<VkDeviceSize>(width) * static_cast<VkDeviceSize>(height) * 8,
                      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::onDevice);
    constexpr std::array kBindings{Binding::storage, Binding::storage};
    layout_ = makeSetLayout(device, kBindings);
    pool_ = makeSetPool(device, 1, kBindings);
    set_ = allocateSet(device, pool_, layout_, std::array<Bound, 2>{{{records_.handle()}, {zBuffer_.handle()}}});
    pipeline_ = makeComputePipeline(device, kBareScatterCode, std::array<VkDescriptorSetLayout, 1>{layout_},
                                    sizeof(Constants), std::array{kWorkgroupSize});
}

double BareScatter::run(const scene::View& view) {
    const glm::mat4 imageFromWorld(imageFromCamera(view.camera) * toMatrix(inverse(view.worldFromEye)));
    Constants constants{};
    std::memcpy(constants.imageFromRecords, &imageFromWorld, sizeof constants.imageFromRecords);
    constants.count = static_cast<std::uint32_t>(samples_);
    constants.width = static_cast<std::uint32_t>(width_), constants.height = static_cast<std::uint32_t>(height_);

    constexpr VkAccessFlags kAll = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    constexpr VkPipelineStageFlags kStages = VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    const VkCommandBuffer commands = streams_.begin(0, 0);
    timer_.begin(commands);
    vkCmdFillBuffer(commands, zBuffer_.handle(), 0, VK_WHOLE_SIZE, 0);
    record(commands, {kStages, kAll, kStages, kAll});
    timer_.mark(commands, "clear");
    bind(commands, pipeline_);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.layout(), 0, 1, &set_, 0, nullptr);
    vkCmdPushConstants(commands, pipeline_.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    vkCmdDispatch(commands, (constants.count + kWorkgroupSize - 1) / kWorkgroupSize, 1, 1);
    record(commands, {kStages, kAll, kStages, kAll});
    timer_.mark(commands, "scatter");
    streams_.submit(0);
    streams_.wait(0);
    std::vector<StepTime> times;
    timer_.read(0, times);
    return times.back().milliseconds;
}

} // namespace render
