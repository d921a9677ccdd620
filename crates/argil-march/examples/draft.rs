use argil_march::*; use argil_field::*; use argil_scene::*; use argil_math::Aabb;
fn main(){ let a:Vec<String>=std::env::args().collect();
 let s=Scene::open(&a[1]).unwrap(); let t=std::time::Instant::now(); let p=Program::lower(&s).unwrap();
 eprintln!("lower {:?} aabb {:?} L {} slack {} slots {:?}",t.elapsed(),p.aabb(),p.lipschitz(),0,p.stack_slots());
 let focus=match s.view.frame {Some([a,b])=>Aabb::new(a.into(),b.into()),None=>p.aabb()};
 let cam=match s.view.camera {Placement::Orbit(o)=>Camera::orbit(focus,o,s.view.field_of_view_degrees),Placement::Look{eye,target}=>Camera{eye:eye.into(),target:target.into(),field_of_view_degrees:s.view.field_of_view_degrees}};
 let size:u32=a.get(3).map_or(640,|v|v.parse().unwrap());
 let set=Settings{size:[size,size*9/16],samples:4,ground:s.view.ground,sun_degrees:s.view.sun_degrees,..Settings::default()};
 let f=frames(&set,&cam,&p,focus); let t=std::time::Instant::now(); let pic=render(&p,&f); eprintln!("{:?} hits {} {:?}",t.elapsed(),hit_pixels(&pic),Statistics::of(&pic.hits));
 image::save_buffer(&a[2],&pic.rgb,pic.size[0],pic.size[1],image::ColorType::Rgb8).unwrap(); }
