// SPDX-License-Identifier: Apache-2.0
// Matrices: primaries and white points of each space, Bradford adaptation to the ACES white, in double
// precision. The aliases are the names of the Color Interop Forum, so that a tag in a file finds its space.
#include "bridge/colour.h"

extern "C" const char *const colour_builtin_config = R"ocio(ocio_profile_version: 2
name: caustics
description: Linear spaces, sRGB and Rec.1886 without look-up tables

environment: {}
search_path: ""
strictparsing: true
luma: [0.2126, 0.7152, 0.0722]

roles:
  aces_interchange: ACES2065-1
  cie_xyz_d65_interchange: CIE-XYZ-D65
  color_timing: ACEScct
  compositing_log: ACEScct
  default: Linear Rec.709
  rendering: Linear Rec.709
  scene_linear: Linear Rec.709
  texture_paint: sRGB Texture

file_rules:
  - !<Rule> {name: Default, colorspace: default}

shared_views:
  - !<View> {name: Standard, view_transform: Standard, display_colorspace: <USE_DISPLAY_NAME>}
  - !<View> {name: ACES SDR, view_transform: ACES SDR, display_colorspace: <USE_DISPLAY_NAME>}
  - !<View> {name: Raw, colorspace: Raw}

displays:
  sRGB:
    - !<Views> [Standard, ACES SDR, Raw]
  Rec.1886:
    - !<Views> [Standard, ACES SDR, Raw]

active_displays: [sRGB, Rec.1886]
active_views: [Standard, ACES SDR, Raw]

default_view_transform: Standard

view_transforms:
  - !<ViewTransform>
    name: Standard
    from_scene_reference: !<BuiltinTransform> {style: UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD}
  - !<ViewTransform>
    name: ACES SDR
    from_scene_reference: !<BuiltinTransform> {style: ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0}

display_colorspaces:
  - !<ColorSpace>
    name: CIE-XYZ-D65
    aliases: [cie_xyz_d65]
    isdata: false
    encoding: display-linear

  - !<ColorSpace>
    name: sRGB
    aliases: [sRGB - Display, srgb_display, srgb_rec709_display]
    isdata: false
    encoding: sdr-video
    from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_sRGB}

  - !<ColorSpace>
    name: Rec.1886
    aliases: [Rec.1886 Rec.709 - Display, rec1886_rec709_display, g24_rec709_display]
    isdata: false
    encoding: sdr-video
    from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_REC.1886-REC.709}

colorspaces:
  - !<ColorSpace>
    name: ACES2065-1
    aliases: [lin_ap0_scene, lin_ap0, aces2065_1, ACES - ACES2065-1]
    isdata: false
    encoding: scene-linear

  - !<ColorSpace>
    name: ACEScg
    aliases: [lin_ap1_scene, lin_ap1, acescg, ACES - ACEScg]
    isdata: false
    encoding: scene-linear
    to_scene_reference: !<MatrixTransform> {matrix: [0.6954522413574518, 0.14067869647029416, 0.16386906217225414, 0, 0.04479456337203783, 0.8596711184564219, 0.09553431817154048, 0, -0.005525882558113543, 0.004025210305978652, 1.0015006722521353, 0, 0, 0, 0, 1]}

  - !<ColorSpace>
    name: ACEScct
    aliases: [acescct, acescct_ap1_scene, ACES - ACEScct]
    isdata: false
    encoding: log
    to_scene_reference: !<BuiltinTransform> {style: ACEScct_to_ACES2065-1}

  - !<ColorSpace>
    name: Linear Rec.709
    aliases: [lin_rec709_scene, lin_rec709, lin_srgb, Linear Rec.709 (sRGB), Utility - Linear - sRGB]
    isdata: false
    encoding: scene-linear
    to_scene_reference: !<MatrixTransform> {matrix: [0.43963298191949113, 0.38298869815155395, 0.17737831992895478, 0, 0.08977644295884231, 0.8134394287489805, 0.09678412829217704, 0, 0.017541170383172704, 0.11154655330238698, 0.8709122763144403, 0, 0, 0, 0, 1]}

  - !<ColorSpace>
    name: Linear P3-D65
    aliases: [lin_p3d65_scene, lin_p3d65, Utility - Linear - P3-D65]
    isdata: false
    encoding: scene-linear
    to_scene_reference: !<MatrixTransform> {matrix: [0.5189334875979807, 0.2862565863866899, 0.19480992601532923, 0, 0.07385938304705991, 0.8198451639369856, 0.10629545301595442, 0, -0.0003070113684466432, 0.04380705025362231, 0.9564999611148242, 0, 0, 0, 0, 1]}

  - !<ColorSpace>
    name: Linear Rec.2020
    aliases: [lin_rec2020_scene, lin_rec2020, Utility - Linear - Rec.2020]
    isdata: false
    encoding: scene-linear
    to_scene_reference: !<MatrixTransform> {matrix: [0.6790856347069117, 0.15770091464315905, 0.16321345064992898, 0, 0.046002003080059535, 0.8590546730029076, 0.09494332391703267, 0, -0.0005739431876161905, 0.028467768408026374, 0.9721061747795896, 0, 0, 0, 0, 1]}

  - !<ColorSpace>
    name: Linear AdobeRGB
    aliases: [lin_adobergb_scene, lin_adobergb]
    isdata: false
    encoding: scene-linear
    to_scene_reference: !<MatrixTransform> {matrix: [0.6147633055017258, 0.2002437025720178, 0.18499299192625654, 0, 0.12553940468386435, 0.7735216222166287, 0.10093897309950683, 0, 0.024528796361104246, 0.06717154353812758, 0.9082996601007682, 0, 0, 0, 0, 1]}

  - !<ColorSpace>
    name: sRGB Texture
    aliases: [srgb_rec709_scene, srgb_tx, Utility - sRGB - Texture]
    isdata: false
    encoding: sdr-video
    to_scene_reference: !<GroupTransform>
      children:
        - !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055}
        - !<MatrixTransform> {matrix: [0.43963298191949113, 0.38298869815155395, 0.17737831992895478, 0, 0.08977644295884231, 0.8134394287489805, 0.09678412829217704, 0, 0.017541170383172704, 0.11154655330238698, 0.8709122763144403, 0, 0, 0, 0, 1]}

  - !<ColorSpace>
    name: Gamma 2.4 Rec.709 Texture
    aliases: [g24_rec709_scene]
    isdata: false
    encoding: sdr-video
    to_scene_reference: !<GroupTransform>
      children:
        - !<ExponentTransform> {value: [2.4, 2.4, 2.4, 1]}
        - !<MatrixTransform> {matrix: [0.43963298191949113, 0.38298869815155395, 0.17737831992895478, 0, 0.08977644295884231, 0.8134394287489805, 0.09678412829217704, 0, 0.017541170383172704, 0.11154655330238698, 0.8709122763144403, 0, 0, 0, 0, 1]}

  - !<ColorSpace>
    name: Raw
    aliases: [data, raw, Utility - Raw]
    isdata: true
    encoding: data
)ocio";
