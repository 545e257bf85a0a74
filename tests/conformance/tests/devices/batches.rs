//! What is asked of every part that is evaluated in batches of its own: lavapipe has the CPU's bits, validation has
//! nothing to say, others are within the tolerances.

use crate::lavapipe::{APIS, lavapipe};
use conformance::devices::{Counter, LAVAPIPE, list, open};
use sinew_gpu::headless::Device;

/// Runs all batches of a part on a device, each of so many instances; returns the values compared, and how many differ.
pub(crate) type Evaluate = fn(&dyn Device, usize) -> (usize, usize);

/// Sees lavapipe have the bits of the CPU, of at least so many values.
pub(crate) fn same_bits(evaluate: Evaluate, instance_len: usize, least: usize) {
    for api in APIS {
        let device = open(&lavapipe(api), false).expect("lavapipe opens");
        let (values, differing) = evaluate(&*device, instance_len);
        println!("{:?}: {differing} of {values} values have other bits", device.info());
        assert_eq!(differing, 0);
        assert!(values > least, "{values}");
    }
}

/// Sees validation have nothing to say.
pub(crate) fn silent(evaluate: Evaluate, instance_len: usize, least: usize) {
    Counter::install();
    for api in APIS {
        let before = Counter::message_len();
        let device = open(&lavapipe(api), true).expect("lavapipe opens with its layer");
        let (values, _) = evaluate(&*device, instance_len);
        let counted = device.message_len().unwrap_or_else(|| Counter::message_len() - before);
        assert!(values > least && counted == 0, "{counted} messages");
    }
}

/// Sees every device but lavapipe stay within the tolerances.
pub(crate) fn within_tolerances(evaluate: Evaluate, instance_len: usize, least: usize) {
    for info in list().expect("devices can be listed").iter().filter(|info| info.driver != LAVAPIPE)
    {
        let device = open(info, false).expect("a device that is listed opens");
        let (values, differing) = evaluate(&*device, instance_len);
        println!("{info:?}: {differing} of {values} values have other bits");
        assert!(values > least, "{values}");
    }
}
