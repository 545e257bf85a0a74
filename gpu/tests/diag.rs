mod common;
use common::*;
use sinew_gpu::headless::Device as _;
use sinew_gpu::layout::*;
use sinew_gpu::wgpu::headless::Device;
use sinew_runtime::envelope::gradients;
#[test]
fn diag() {
    let device = Device::of_driver("llvmpipe", true).unwrap();
    for bytes in GOLDEN {
        let (model, env) = load(bytes);
        let batch = Batch::palettes(&env, 67);
        let plan = Plan::new(&model, &env, &batch, &device.limits()).unwrap();
        let ps = poses(&env, 67);
        let mut up = device.upload(&model, &plan).unwrap();
        let flat: Vec<f32> = ps.iter().flatten().flatten().flatten().copied().collect();
        up.write(Resource::Poses, 0, &flat).unwrap();
        up.run(67).unwrap();
        let pal = up.read(Resource::Palettes).unwrap();
        let work = up.read(Resource::Work).unwrap();
        let w = WorkLayout::new(&env);
        eprintln!("{:?} J {} P {} w {w:?}", env.predictor(), env.joint_len(), env.proxy_len());
        let n = 12*env.palette_len();
        for i in 0..67 {
            let mut ws = vec![0.0; env.workspace_len()];
            let mut p = vec![[[0.0;4];3]; env.palette_len()];
            env.palette(&ps[i], &mut ws, &mut p).unwrap();
            let p = p.as_flattened().as_flattened();
            let bad: Vec<usize> = (0..n).filter(|k| pal[i*n+k].to_bits()!=p[*k].to_bits()).collect();
            if env.predictor().reconstructs() {
                let mut rel = vec![[0.0;3]; 4*env.joint_len()];
                let mut rot = vec![[0.0;3]; env.joint_len()];
                let mut gr = vec![[0.0;3]; 3*env.proxy_len()];
                gradients::evaluate(&env, &ps[i], &mut rel, &mut rot, &mut gr).unwrap();
                let cmp = |at: usize, cpu: &[f32]| cpu.iter().enumerate().filter(|(k, x)| work[i*w.len+at+k].to_bits()!=x.to_bits()).map(|(k,x)|(k,*x,work[i*w.len+at+k])).collect::<Vec<_>>();
                let a = cmp(w.relative, rel.as_flattened()); let b = cmp(w.rotations, rot.as_flattened()); let c = cmp(w.gradients, gr.as_flattened());
                if bad.len()+a.len()+b.len()+c.len()>0 { eprintln!("{i}: palette {} rel {:?} rot {:?} grad {:?}", bad.len(), a.len(), b, &c[..c.len().min(3)]); }
            } else if bad.len()>0 { eprintln!("{i}: {bad:?}"); }
        }
    }
}
