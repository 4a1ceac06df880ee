// Records pictures of a USD stage with the engine of usdrecord --disableGpu, without a window: a host for tests.
//
// Argument: a JSON file with stage, camera, size, aovs, complexity, purposes (besides default), renderSettings (a prim)
// and frames, each with settings to set before it, time, and out. Each picture is out.AOV.raw, floats with rows from
// the bottom up, and a line "PICTURE {json}" with the file, its size and its channels. With `record`, usdrecord's own
// recorder writes frames instead, as files of that ending. With `shaders`, names of nodes, it renders nothing and
// prints "NODE {json}" with what the registry of shaders knows of each.
#include <pxr/base/tf/diagnostic.h>
#include <pxr/imaging/hd/renderBuffer.h>
#include <pxr/imaging/hdx/taskController.h>
#include <pxr/usd/sdr/registry.h>
#include <pxr/usd/sdr/shaderProperty.h>
#include <pxr/usd/usd/stage.h>
#include <pxr/usd/usdGeom/camera.h>
#include <pxr/usdImaging/usdAppUtils/frameRecorder.h>
#include <pxr/usdImaging/usdImagingGL/engine.h>

#include <chrono>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

using namespace pxr;
using nlohmann::json;

namespace {

const TfToken kRenderer("HdAlabasterRendererPlugin");

// Applications choose one output at a time; this one has several.
class Engine : public UsdImagingGLEngine {
 public:
  Engine() : UsdImagingGLEngine(HdDriver(), kRenderer, false) {}
  void set_outputs(const TfTokenVector& aovs) { _GetTaskController()->SetRenderOutputs(aovs); }
};

VtValue to_value(const json& value) {
  if (value.is_boolean()) return VtValue(value.get<bool>());
  if (value.is_number_integer()) return VtValue(value.get<int>());
  if (value.is_number()) return VtValue(value.get<float>());
  return VtValue(value.get<std::string>());
}

UsdTimeCode time_of(const json& frame) {
  return frame.contains("time") ? UsdTimeCode(frame["time"].get<double>()) : UsdTimeCode::EarliestTime();
}

bool has_purpose(const json& job, const char* purpose) {
  for (const json& one : job.value("purposes", json::array()))
    if (one == purpose) return true;
  return false;
}

// Numbers of any type as floats.
bool write(HdRenderBuffer* buffer, const std::string& file) {
  if (!buffer) return false;
  buffer->Resolve();
  const size_t channels = HdGetComponentCount(buffer->GetFormat());
  const HdFormat component = HdGetComponentFormat(buffer->GetFormat());
  std::vector<float> pixels(buffer->GetWidth() * buffer->GetHeight() * channels);
  const void* const data = buffer->Map();
  for (size_t i = 0; i < pixels.size(); ++i)
    pixels[i] = component == HdFormatInt32 ? static_cast<float>(static_cast<const int*>(data)[i])
                                           : static_cast<const float*>(data)[i];
  buffer->Unmap();
  if (component != HdFormatInt32 && component != HdFormatFloat32) return false;
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(pixels.data()), static_cast<std::streamsize>(pixels.size() * sizeof(float)));
  std::cout << "\nPICTURE "
            << json{{"file", file},
                    {"width", buffer->GetWidth()},
                    {"height", buffer->GetHeight()},
                    {"channels", channels}}
            << std::endl;
  return bool(out);
}

bool render(Engine& engine, const UsdStageRefPtr& stage, const json& job, const json& frame) {
  UsdImagingGLRenderParams params;
  params.frame = time_of(frame);
  params.complexity = job.value("complexity", 1.0f);
  params.showRender = has_purpose(job, "render");
  params.showProxy = has_purpose(job, "proxy");
  params.showGuides = has_purpose(job, "guide");
  params.cullStyle = UsdImagingGLCullStyle::CULL_STYLE_NO_OPINION;
  params.colorCorrectionMode = TfToken("disabled");
  params.clearColor = GfVec4f(0);
  const json settings = frame.value("settings", json::object());
  for (const auto& [name, value] : settings.items()) engine.SetRendererSetting(TfToken(name), to_value(value));
  for (;;) {
    engine.Render(stage->GetPseudoRoot(), params);
    if (engine.IsConverged()) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  for (const std::string aov : job.value("aovs", json{"color"}))
    if (!write(engine.GetAovRenderBuffer(TfToken(aov)), frame["out"].get<std::string>() + "." + aov + ".raw"))
      return std::cerr << "no pixels of AOV " << aov << std::endl, false;
  return true;
}

bool render_all(const UsdStageRefPtr& stage, const json& job) {
  Engine engine;
  engine.SetEnablePresentation(false);
  TfTokenVector aovs;
  for (const std::string aov : job.value("aovs", json{"color"})) aovs.emplace_back(aov);
  engine.set_outputs(aovs);
  const GfVec2i size(job["size"][0].get<int>(), job["size"][1].get<int>());
  engine.SetCameraPath(SdfPath(job["camera"].get<std::string>()));
  engine.SetFraming(CameraUtilFraming(GfRect2i(GfVec2i(0), size[0], size[1])));
  engine.SetRenderBufferSize(size);
  engine.SetLightingState({}, {}, GfVec4f(0));
  if (job.contains("renderSettings"))
    engine.SetActiveRenderSettingsPrimPath(SdfPath(job["renderSettings"].get<std::string>()));
  for (const json& frame : job["frames"])
    if (!render(engine, stage, job, frame)) return false;
  return true;
}

// The class behind the program usdrecord, as it calls it with --disableGpu and --disableCameraLight.
bool record_all(const UsdStageRefPtr& stage, const json& job) {
  const SdfPath settings =
      job.contains("renderSettings") ? SdfPath(job["renderSettings"].get<std::string>()) : SdfPath();
  UsdAppUtilsFrameRecorder recorder(kRenderer, false, settings);
  recorder.SetImageWidth(job["size"][0].get<size_t>());
  recorder.SetComplexity(job.value("complexity", 1.0f));
  recorder.SetCameraLightEnabled(false);
  const UsdGeomCamera camera(stage->GetPrimAtPath(SdfPath(job["camera"].get<std::string>())));
  for (const json& frame : job["frames"])
    if (!recorder.Record(stage, camera, time_of(frame),
                         frame["out"].get<std::string>() + "." + job["record"].get<std::string>()))
      return false;
  return true;
}

json described(const SdrShaderPropertyConstPtr& property) {
  json metadata = json::object();
  for (const auto& [key, value] : property->GetMetadata()) metadata[key.GetString()] = value;
  json options = json::array();
  for (const auto& [name, value] : property->GetOptions()) options.push_back(name.GetString());
  return {{"options", options},
          {"type", property->GetTypeAsSdfType().first.GetAsToken().GetString()},
          {"default", TfStringify(property->GetDefaultValueAsSdfType())},
          {"help", property->GetHelp()},
          {"connectable", property->IsConnectable()},
          {"metadata", metadata}};
}

// As an application lists the inputs of a node. False if the registry does not know it.
bool list_node(const std::string& name) {
  const auto node = SdrRegistry::GetInstance().GetShaderNodeByIdentifier(TfToken(name));
  if (!node || !node->IsValid()) return std::cerr << "no shader " << name << std::endl, false;
  json inputs = json::object(), outputs = json::array();
  for (const TfToken& input : node->GetInputNames()) inputs[input.GetString()] = described(node->GetShaderInput(input));
  for (const TfToken& output : node->GetOutputNames()) outputs.push_back(output.GetString());
  std::cout << "\nNODE " << json{{"name", name}, {"help", node->GetHelp()}, {"inputs", inputs}, {"outputs", outputs}}
            << std::endl;
  return true;
}

}  // namespace

int main(int count, char** words) {
  if (count != 2) return std::cerr << "usage: record_stage JOB.json" << std::endl, 2;
  try {
    const json job = json::parse(std::ifstream(words[1]));
    if (job.contains("shaders")) {
      bool known = true;
      for (const std::string name : job["shaders"]) known &= list_node(name);
      return known ? 0 : 1;
    }
    const UsdStageRefPtr stage = UsdStage::Open(job["stage"].get<std::string>());
    if (!stage) return 1;
    return (job.contains("record") ? record_all(stage, job) : render_all(stage, job)) ? 0 : 1;
  } catch (const std::exception& e) {
    return std::cerr << words[1] << ": " << e.what() << std::endl, 2;
  }
}
