#include "core/color/builtin_config.h"

namespace alabaster {

// The Academy's output transforms are chosen for the viewing condition of each display: dim-surround video for sRGB and
// Rec.1886, dark-surround cinema for P3-D65 at gamma 2.6, 1000 nit HDR video for Rec.2100-PQ.
const char* builtin_config_text() {
  return R"(ocio_profile_version: 2

environment: {}
search_path: ""
strictparsing: true
luma: [0.2126, 0.7152, 0.0722]
name: Alabaster built-in
description: Linear Rec.709 rendering; ACES 1.x and un-tone-mapped views. Made of OpenColorIO's built-in transforms alone.

roles:
  aces_interchange: ACES2065-1
  cie_xyz_d65_interchange: CIE-XYZ-D65
  color_picking: sRGB - Texture
  data: Raw
  default: Linear Rec.709
  matte_paint: sRGB - Texture
  reference: ACES2065-1
  rendering: Linear Rec.709
  scene_linear: Linear Rec.709
  texture_paint: sRGB - Texture

file_rules:
  - !<Rule> {name: Default, colorspace: Linear Rec.709}

displays:
  sRGB:
    - !<View> {name: ACES, view_transform: ACES SDR Video, display_colorspace: sRGB - Display}
    - !<View> {name: Un-tone-mapped, view_transform: Un-tone-mapped, display_colorspace: sRGB - Display}
    - !<View> {name: Raw, colorspace: Raw}
  Rec.709:
    - !<View> {name: ACES, view_transform: ACES SDR Video, display_colorspace: Rec.1886 Rec.709 - Display}
    - !<View> {name: Un-tone-mapped, view_transform: Un-tone-mapped, display_colorspace: Rec.1886 Rec.709 - Display}
    - !<View> {name: Raw, colorspace: Raw}
  P3-D65:
    - !<View> {name: ACES, view_transform: ACES SDR Cinema, display_colorspace: P3-D65 - Display}
    - !<View> {name: Un-tone-mapped, view_transform: Un-tone-mapped, display_colorspace: P3-D65 - Display}
    - !<View> {name: Raw, colorspace: Raw}
  Rec.2100-PQ:
    - !<View> {name: ACES, view_transform: ACES HDR Video 1000 nits, display_colorspace: Rec.2100-PQ - Display}
    - !<View> {name: Un-tone-mapped, view_transform: Un-tone-mapped, display_colorspace: Rec.2100-PQ - Display}
    - !<View> {name: Raw, colorspace: Raw}

active_displays: [sRGB, Rec.709, P3-D65, Rec.2100-PQ]
active_views: [ACES, Un-tone-mapped, Raw]

default_view_transform: Un-tone-mapped

view_transforms:
  - !<ViewTransform>
    name: Un-tone-mapped
    from_scene_reference: !<BuiltinTransform> {style: UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD}

  - !<ViewTransform>
    name: ACES SDR Video
    from_scene_reference: !<BuiltinTransform> {style: ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0}

  - !<ViewTransform>
    name: ACES SDR Cinema
    from_scene_reference: !<BuiltinTransform> {style: ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-CINEMA_1.0}

  - !<ViewTransform>
    name: ACES HDR Video 1000 nits
    from_scene_reference: !<BuiltinTransform> {style: ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - HDR-VIDEO-1000nit-15nit-REC2020lim_1.1}

display_colorspaces:
  - !<ColorSpace>
    name: CIE-XYZ-D65
    family: Display
    encoding: display-linear
    isdata: false
    description: The display reference space, CIE XYZ adapted to D65.

  - !<ColorSpace>
    name: sRGB - Display
    family: Display
    encoding: sdr-video
    isdata: false
    from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_sRGB}

  - !<ColorSpace>
    name: Rec.1886 Rec.709 - Display
    family: Display
    encoding: sdr-video
    isdata: false
    from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_REC.1886-REC.709}

  - !<ColorSpace>
    name: P3-D65 - Display
    family: Display
    encoding: sdr-video
    isdata: false
    from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_G2.6-P3-D65}

  - !<ColorSpace>
    name: Rec.2100-PQ - Display
    family: Display
    encoding: hdr-video
    isdata: false
    from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_REC.2100-PQ}

colorspaces:
  - !<ColorSpace>
    name: ACES2065-1
    aliases: [aces2065_1, lin_ap0]
    family: Scene
    encoding: scene-linear
    isdata: false
    description: The scene reference space, linear AP0.

  - !<ColorSpace>
    name: ACEScg
    aliases: [acescg, lin_ap1]
    family: Scene
    encoding: scene-linear
    isdata: false
    to_scene_reference: !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}

  - !<ColorSpace>
    name: Linear Rec.709
    aliases: [lin_rec709, lin_srgb, linear]
    family: Scene
    encoding: scene-linear
    isdata: false
    description: Linear light, Rec.709 primaries, D65 white. The rendering space.
    from_scene_reference: !<GroupTransform>
      children:
        - !<BuiltinTransform> {style: ACEScg_to_ACES2065-1, direction: inverse}
        - !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_LINEAR-REC709_BFD}

  - !<ColorSpace>
    name: sRGB - Texture
    aliases: [srgb_texture, srgb_tx]
    family: Texture
    encoding: sdr-video
    isdata: false
    description: Rec.709 primaries with the sRGB curve; 8-bit colour images.
    from_scene_reference: !<GroupTransform>
      children:
        - !<BuiltinTransform> {style: ACEScg_to_ACES2065-1, direction: inverse}
        - !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_LINEAR-REC709_BFD}
        - !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055, direction: inverse}

  - !<ColorSpace>
    name: g22_rec709
    family: Texture
    encoding: sdr-video
    isdata: false
    to_scene_reference: !<GroupTransform>
      children:
        - !<ExponentTransform> {value: [2.2, 2.2, 2.2, 1]}
        - !<ColorSpaceTransform> {src: Linear Rec.709, dst: ACES2065-1}

  - !<ColorSpace>
    name: g18_rec709
    family: Texture
    encoding: sdr-video
    isdata: false
    to_scene_reference: !<GroupTransform>
      children:
        - !<ExponentTransform> {value: [1.8, 1.8, 1.8, 1]}
        - !<ColorSpaceTransform> {src: Linear Rec.709, dst: ACES2065-1}

  - !<ColorSpace>
    name: lin_displayp3
    family: Scene
    encoding: scene-linear
    isdata: false
    to_scene_reference: !<GroupTransform>
      children:
        - !<MatrixTransform> {matrix: [1.22494018, -0.22494018, 0, 0, -0.04205695, 1.04205695, 0, 0, -0.01963755, -0.07863605, 1.0982736, 0, 0, 0, 0, 1]}
        - !<ColorSpaceTransform> {src: Linear Rec.709, dst: ACES2065-1}

  - !<ColorSpace>
    name: srgb_displayp3
    family: Texture
    encoding: sdr-video
    isdata: false
    to_scene_reference: !<GroupTransform>
      children:
        - !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055}
        - !<ColorSpaceTransform> {src: lin_displayp3, dst: ACES2065-1}

  - !<ColorSpace>
    name: Raw
    family: Utility
    encoding: data
    isdata: true
    description: Not a colour; never converted.
)";
}

}  // namespace alabaster
